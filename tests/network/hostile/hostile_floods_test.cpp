// Sets a program of the tests' own (attacker.cpp) against whole programs of the product.
#include "tests/network/hostile/hostile_floods.h"

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <optional>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sched.h>

#include "collab/controller/controller.h"
#include "collab/dds/security/keys.h"
#include "tests/network/running_program.h"
#include "tests/network/syscall_count.h"
#include "tests/support/machine/empty_loop.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;
using testing::HostileFloods;
using testing::kDomain;
using testing::LinesOf;
using ::testing::Not;
using testing::Program;

constexpr long kStatesOfAFlood = 60'000;

/// Returns the real-time priority of a program's thread; 0: it is not a real-time thread.
int PriorityOf(Program& program, const std::string& thread) {
  const std::optional<pid_t> id = testing::AwaitThread(program.process().pid(), thread);
  sched_param parameters{};
  if (!id || sched_getparam(*id, &parameters) != 0) return -1;
  return parameters.sched_priority;
}

TEST_F(HostileFloods, StatesOfForgedBodiesTakeNoMemoryAndAreReported) {
  Program anna = Peer();
  ASSERT_TRUE(anna.Says("is in session"));
  ExpectLittle(GrowthUnder("keys", anna));
  EXPECT_GT(sent_, 20'000);
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
  const nlohmann::json drops = Report().at("drops");
  EXPECT_GT(drops.at("flood").get<long>() + drops.at("many_keys").get<long>(), sent_ / 4);
  EXPECT_THAT(anna.output(), HasSubstr("ignored for a second"));
}

// Cyclone's thread "gc" frees what readers did not keep. Where it waits for a core that long,
// nothing is freed.
TEST_F(HostileFloods, ForgedBodiesTakeNoMemoryWhileGarbageCollectionIsStopped) {
  Program anna = Peer();
  ASSERT_TRUE(anna.Says("is in session"));
  stopped_thread_ = "gc";
  ExpectLittle(GrowthUnder("keys", anna));
  EXPECT_GT(sent_, 20'000);
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
  EXPECT_GT(Report().at("drops").at("many_keys").get<long>(), 1000);
}

TEST_F(HostileFloods, MembersForgedBodiesAreBoundedAsAStrangers) {
  Program anna = SecuredPeer("ben", Role::kActive);
  ASSERT_TRUE(anna.Says("is in session"));
  ExpectLittle(GrowthUnder("keys", anna, "ben", In("keys-ben").string()));
  EXPECT_GT(sent_, 5'000);
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
  const nlohmann::json drops = Report().at("drops");
  EXPECT_GT(drops.at("flood").get<long>() + drops.at("many_keys").get<long>(), 1000);
}

TEST_F(HostileFloods, ForgedViewersWithAViewersKeysTakeNoMemory) {
  Program anna = SecuredPeer("vic", Role::kViewer);
  ASSERT_TRUE(anna.Says("is in session"));
  ExpectLittle(GrowthUnder("lookers", anna, "", In("keys-vic").string()));
  EXPECT_GT(sent_, 2000);
  EXPECT_THAT(anna.output(), Not(HasSubstr("looker-")));
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
  const nlohmann::json drops = Report().at("drops");
  EXPECT_GT(drops.at("flood").get<long>() + drops.at("many_keys").get<long>(), 1000);
}

// Where there is one core for all of a peer's threads, those that receive stand below the hand's.
TEST_F(HostileFloods, StrangersStatesDoNotStarveTheHapticThread) {
  cpu_set_t all;
  ASSERT_EQ(sched_getaffinity(0, sizeof all, &all), 0);
  int last = 0;
  for (int core = 0; core < CPU_SETSIZE; ++core) last = CPU_ISSET(core, &all) ? core : last;
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(last, &one);
  ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
  Program anna = Peer();
  if (CPU_COUNT(&all) > 1) CPU_CLR(last, &all);
  ASSERT_EQ(sched_setaffinity(0, sizeof all, &all), 0);
  Program attacker = Attack("flood", "-", 30, kStatesOfAFlood);
  ASSERT_TRUE(attacker.Says("joined")) << attacker.output();
  ASSERT_TRUE(anna.Says("you hold peg")) << anna.output();
  if (PriorityOf(anna, "haptic") == 0) GTEST_SKIP() << "real-time threads are refused here";
  for (const char* receives : {"recv", "recvUC"}) {
    EXPECT_LT(PriorityOf(anna, receives), PriorityOf(anna, "haptic")) << receives;
  }
  testing::EmptyLoop empty(last);
  attacker.process().Signal(SIGUSR1);
  EXPECT_EQ(attacker.Wait(), 0);
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
  const double machine_missed = empty.End();
  const nlohmann::json report = Report();
  const auto sent = std::stol(attacker.output().substr(attacker.output().find("sent ") + 5));
  EXPECT_EQ(sent, kStatesOfAFlood);
  EXPECT_GT(report.at("drops").at("flood").get<long>(), sent / 4);
  EXPECT_LE(report.at("judged_missed").get<double>(),
            (0.05 + 2 * std::min(machine_missed, 0.2)) * report.at("judged_frames").get<double>());
}

TEST_F(HostileFloods, ForgedNamesTakeNoMemoryAndFewLines) {
  Program anna = Peer();
  ASSERT_TRUE(anna.Says("is in session"));
  ExpectLittle(GrowthUnder("names", anna));
  EXPECT_GT(sent_, 5000);
  EXPECT_LE(static_cast<double>(lines_), 10 * (seconds_ + 1));
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
  EXPECT_GT(Report().at("drops").at("flood").get<long>(), 1000);
}

TEST_F(HostileFloods, MembersForgedNamesTakeNoMemoryAndAreNotShown) {
  Program anna = SecuredPeer("ben", Role::kActive);
  ASSERT_TRUE(anna.Says("is in session"));
  ExpectLittle(GrowthUnder("names", anna, "ben", In("keys-ben").string()));
  EXPECT_GT(sent_, 2000);
  EXPECT_THAT(anna.output(), Not(HasSubstr("vic-")));
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
}

TEST_F(HostileFloods, IncompleteSamplesTakeNoMemory) {
  Program anna = Peer();
  ASSERT_TRUE(anna.Says("is in session"));
  ExpectLittle(GrowthUnder("pieces", anna));
  EXPECT_GT(sent_, 1000);
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
}

TEST_F(HostileFloods, ForgedHostsDoNotFillAController) {
  Program anna = Peer({"--control", session_});
  ASSERT_TRUE(anna.Says("is in session"));
  ExpectLittle(GrowthUnder("hosts", anna, ""));
  EXPECT_GT(sent_, 5000);
  EXPECT_THAT(anna.output(), HasSubstr("floods the controller"));
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
}

TEST_F(HostileFloods, HostAttachesDuringAFloodOfForgedHosts) {
  Program anna = Peer({"--control", session_});
  ASSERT_TRUE(anna.Says("is in session"));
  Program attacker = Attack("hosts");
  ASSERT_TRUE(attacker.Says("joined")) << attacker.output();
  attacker.process().Signal(SIGUSR1);
  ASSERT_TRUE(anna.Says("floods the controller")) << anna.output();
  Controller::Options options;
  options.timeout_s = 10;
  Result<Controller> host = Controller::Attach(session_, options);
  ASSERT_TRUE(host) << host.error().what;
  EXPECT_FALSE(attacker.process().Poll()) << "the flood had ended";
  EXPECT_TRUE(host->Ask(SnapshotRateRequest{}).ok);
  EXPECT_EQ(attacker.Wait(), 0);
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
}

TEST_F(HostileFloods, ForgedAnnouncementsAreDroppedBeforeDdsAndReportedOnce) {
  Program anna = Peer();
  ASSERT_TRUE(anna.Says("is in session"));
  ExpectLittle(GrowthUnder("packets", anna, ""));
  EXPECT_GT(sent_, 20'000);
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
  EXPECT_GT(Report().at("packets_refused").at("new_sender").get<long>(), 1000);
  int reported = 0;
  for (const std::string& line : LinesOf(anna.output())) {
    reported += line.find("announces more programs than there can be") != std::string::npos ? 1 : 0;
  }
  EXPECT_EQ(reported, 1) << anna.output();
}

TEST_F(HostileFloods, StrangersAnnouncementsTakeNoMemoryInASecuredSession) {
  const std::filesystem::path keys = In("keys");
  ASSERT_TRUE(MakeSessionKeys(keys));
  ASSERT_TRUE(MakeMemberKeys(keys, "anna", Role::kActive, In("keys-anna")));
  Program anna = Peer({"--secure", In("keys-anna").string()});
  ASSERT_TRUE(anna.Says("is in session"));
  ExpectLittle(GrowthUnder("packets", anna, ""));
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
  EXPECT_GT(Report().at("packets_refused").at("new_sender").get<long>(), 1000);
}

TEST_F(HostileFloods, ForgedDisposalsTakeNoMemoryAndDelayNoPeer) {
  Program anna = Peer();
  ASSERT_TRUE(anna.Says("is in session"));
  ExpectLittle(GrowthUnder("ends", anna));
  // the thread that hears them all goes on: another is seen to come
  Program ben = Program({TANDEM_PROGRAM, "watch", "--session", session_, "--interface", "lo",
                         "--domain", kDomain, "--name", "ben"},
                        In("ben"));
  EXPECT_TRUE(anna.Says("ben (viewer) joined", 20)) << anna.output();
  ben.process().Signal(SIGTERM);
  EXPECT_EQ(ben.Wait(), 0);
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
}

TEST_F(HostileFloods, RepeatedJoinsAreReportedOnceASecond) {
  Program anna = Peer();
  ASSERT_TRUE(anna.Says("is in session"));
  GrowthUnder("flap", anna);
  EXPECT_GT(lines_, 0U);
  EXPECT_LE(static_cast<double>(lines_), 2 * (seconds_ + 2));
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
}

TEST_F(HostileFloods, InvalidNameLeavesReportAndLogReadable) {
  Program anna = Peer();
  ASSERT_TRUE(anna.Says("is in session"));
  Program attacker = Attack("name", "-", 0);
  // each byte that is no text, and each character that must not be shown, is one question mark
  ASSERT_TRUE(anna.Says("b???d")) << anna.output();
  attacker.process().Signal(SIGUSR1);
  EXPECT_EQ(attacker.Wait(), 0);
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
  EXPECT_TRUE(Report().is_object());
  EXPECT_THAT(anna.output(), Not(HasSubstr("\xff")));
}

TEST_F(HostileFloods, ForgedManifestsDoNotFillARelay) {
  Program relay = Program(
      {TANDEM_PROGRAM, "relay", "--session", session_, "--interface", "lo", "--domain", kDomain},
      In("relay"));
  ASSERT_TRUE(relay.Says("relaying session"));
  ExpectLittle(GrowthUnder("scenes", relay, ""));
  EXPECT_GT(sent_, 2000);
  relay.process().Signal(SIGTERM);
  EXPECT_EQ(relay.Wait(), 0);
}

TEST_F(HostileFloods, ForgedBodiesDoNotFillAViewer) {
  Program watch = Program(
      {TANDEM_PROGRAM, "watch", "--session", session_, "--interface", "lo", "--domain", kDomain},
      In("watch"));
  ASSERT_TRUE(watch.Says("watching session"));
  ExpectLittle(GrowthUnder("views", watch, ""));
  EXPECT_GT(sent_, 2000);
  watch.process().Signal(SIGTERM);
  EXPECT_EQ(watch.Wait(), 0);
  for (const std::string& line : LinesOf(watch.output())) EXPECT_LT(line.size(), 2000U);
}

}  // namespace
}  // namespace tandem
