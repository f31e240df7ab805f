// Sets a program of the tests' own (attacker.cpp) against whole programs of the product.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <random>
#include <sstream>
#include <thread>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sched.h>
#include <unistd.h>

#include "app/cli/child_processes.h"
#include "collab/controller/controller.h"
#include "collab/dds/keys.h"
#include "tests/network/flood_growth.h"
#include "tests/network/said_program.h"
#include "tests/network/stopped_thread.h"
#include "tests/network/syscall_count.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;
using testing::kGivenBackSeconds;
using testing::kMostGrowth;
using testing::kMostKept;
using testing::LinesOf;
using testing::MemoryAtRest;
using ::testing::Not;
using testing::Program;
using testing::StoppedThread;

constexpr double kFloodSeconds = 3;
// a DDS domain that no other test has: packets flood all programs of the domain
constexpr const char* kDomain = "71";
constexpr double kFullSeconds = 600;  // longest time of a flood of a given size

/// Returns how much a flood of that mode sends where TANDEM_FLOODS asks for full size; 0: it goes
/// by the clock.
long FullSizeOf(const std::string& mode) {
  if (std::getenv("TANDEM_FLOODS") == nullptr) return 0;  // NOLINT(concurrency-mt-unsafe)
  if (mode == "keys" || mode == "names" || mode == "lookers") return 1'000'000;
  return mode == "packets" ? 100'000 : 0;
}

/// Returns the real-time priority of a program's thread; 0: it is not a real-time thread.
int PriorityOf(Program& program, const std::string& thread) {
  const std::optional<pid_t> id = testing::AwaitThread(program.process().pid(), thread);
  sched_param parameters{};
  if (!id || sched_getparam(*id, &parameters) != 0) return -1;
  return parameters.sched_priority;
}

/// A session with one peer of the product, that holds a body.
class HostileFloods : public ::testing::Test {
 protected:
  HostileFloods() : session_("floods-" + std::to_string(std::random_device{}())) {}

  std::filesystem::path In(const std::string& file) const { return folder_.path() / file; }
  Program Peer(const std::vector<std::string>& more = {}) const {
    const std::filesystem::path scenes = TANDEM_SCENES;
    std::vector<std::string> words{TANDEM_PROGRAM,
                                   "peer",
                                   "--session",
                                   session_,
                                   "--interface",
                                   "lo",
                                   "--domain",
                                   kDomain,
                                   "--scene",
                                   (scenes / "peg_in_slot.json").string(),
                                   "--hold",
                                   "peg",
                                   "--name",
                                   "anna",
                                   "--capacity",
                                   "20000",
                                   "--brief",
                                   "--report",
                                   In("report").string()};
    words.insert(words.end(), more.begin(), more.end());
    return Program(words, In("anna"));
  }
  /// Starts the peer of a secured session, with keys for an attacker of that name beside it.
  Program SecuredPeer(const std::string& attacker, Role role) const {
    const std::filesystem::path keys = In("keys");
    EXPECT_TRUE(MakeSessionKeys(keys));
    EXPECT_TRUE(MakeMemberKeys(keys, "anna", Role::kActive, In("keys-anna")));
    EXPECT_TRUE(MakeMemberKeys(keys, attacker, role, In("keys-" + attacker)));
    return Peer({"--secure", In("keys-anna").string()});
  }
  Program Attack(const std::string& mode, const std::string& keys = "-",
                 double seconds = kFloodSeconds) const {
    const long size = FullSizeOf(mode);
    return Program({TANDEM_ATTACKER, session_, keys, "153", mode,
                    std::to_string(size > 0 ? kFullSeconds : seconds), std::to_string(size), "lo",
                    "-", kDomain},
                   In("attacker"));
  }
  nlohmann::json Report() const {
    std::ifstream stream(In("report"));
    return nlohmann::json::parse(stream, nullptr, false);
  }

  /// Growth of a program's memory in a flood, in bytes more than before it.
  struct Growth {
    std::int64_t most = 0;
    std::int64_t kept = 0;  // the least of the minute after it
  };

  /// Lets the attack run against a program that is there already. It begins when the program has
  /// heard of a peer `knows` (empty: it hears of none) and its memory stands still.
  Growth GrowthUnder(const std::string& mode, Program& victim, const std::string& knows = "vic",
                     const std::string& keys = "-") {
    Program attacker = Attack(mode, keys);
    EXPECT_TRUE(attacker.Says("joined")) << attacker.said();
    // it has no scene
    if (!knows.empty()) {
      EXPECT_TRUE(victim.Says(knows + " is not taken in")) << victim.said();
    }
    const std::int64_t before = MemoryAtRest(victim);
    EXPECT_GT(before, 0);
    const std::size_t lines_before = LinesOf(victim.said()).size();
    const auto begun = std::chrono::steady_clock::now();
    std::optional<StoppedThread> stopped;
    if (!stopped_thread_.empty()) {
      stopped.emplace(victim.process().pid(), stopped_thread_);
      EXPECT_TRUE(stopped->stopped());
    }
    attacker.process().Signal(SIGUSR1);
    Growth growth;
    while (!attacker.process().Poll()) {
      growth.most = std::max(growth.most, victim.Memory() - before);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    stopped.reset();
    seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    lines_ = LinesOf(victim.said()).size() - lines_before;
    EXPECT_THAT(attacker.said(), HasSubstr("sent "));
    sent_ = std::stol(attacker.said().substr(attacker.said().find("sent ") + 5));
    if (FullSizeOf(mode) > 0) {
      EXPECT_EQ(sent_, FullSizeOf(mode));
    }
    growth.kept = victim.Memory() - before;
    for (double waited = 0; growth.kept > kMostKept && waited < kGivenBackSeconds; waited += 0.1) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      growth.kept = std::min(growth.kept, victim.Memory() - before);
    }
    RecordProperty("sent", static_cast<int>(sent_));
    RecordProperty("growth_kb", static_cast<int>(growth.most / 1024));
    RecordProperty("kept_kb", static_cast<int>(growth.kept / 1024));
    return growth;
  }
  static void ExpectLittle(const Growth& growth) {
    EXPECT_LE(growth.most, kMostGrowth);
    EXPECT_LE(growth.kept, kMostKept);
  }

  const TemporaryFolder folder_;
  const std::string session_;
  std::string stopped_thread_;  // victim's thread, stopped during the flood; empty: none
  long sent_ = 0;
  double seconds_ = 0;     // duration of the flood
  std::size_t lines_ = 0;  // number of lines that the victim said meanwhile
};

TEST_F(HostileFloods, StatesOfInventedBodiesTakeNoMemoryAreCountedAndTold) {
  Program anna = Peer();
  ASSERT_TRUE(anna.Says("is in session"));
  ExpectLittle(GrowthUnder("keys", anna));
  EXPECT_GT(sent_, 20'000);
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
  const nlohmann::json drops = Report().at("drops");
  EXPECT_GT(drops.at("flood").get<long>() + drops.at("many_keys").get<long>(), sent_ / 4);
  EXPECT_THAT(anna.said(), HasSubstr("not heard for a second"));
}

// Cyclone's thread "gc" frees what readers did not keep. Where it waits for a core that long,
// nothing is freed.
TEST_F(HostileFloods, InventedBodiesTakeNoMemoryWhileNothingIsFreed) {
  Program anna = Peer();
  ASSERT_TRUE(anna.Says("is in session"));
  stopped_thread_ = "gc";
  ExpectLittle(GrowthUnder("keys", anna));
  EXPECT_GT(sent_, 20'000);
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
  EXPECT_GT(Report().at("drops").at("many_keys").get<long>(), 1000);
}

TEST_F(HostileFloods, AMembersInventedBodiesTakeNoMoreThanAStrangers) {
  Program anna = SecuredPeer("ben", Role::kActive);
  ASSERT_TRUE(anna.Says("is in session"));
  ExpectLittle(GrowthUnder("keys", anna, "ben", In("keys-ben").string()));
  EXPECT_GT(sent_, 5'000);
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
  const nlohmann::json drops = Report().at("drops");
  EXPECT_GT(drops.at("flood").get<long>() + drops.at("many_keys").get<long>(), 1000);
}

TEST_F(HostileFloods, InventedViewersOfAViewersKeysTakeNoMemory) {
  Program anna = SecuredPeer("vic", Role::kViewer);
  ASSERT_TRUE(anna.Says("is in session"));
  ExpectLittle(GrowthUnder("lookers", anna, "", In("keys-vic").string()));
  EXPECT_GT(sent_, 2000);
  EXPECT_THAT(anna.said(), Not(HasSubstr("looker-")));
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
  const nlohmann::json drops = Report().at("drops");
  EXPECT_GT(drops.at("flood").get<long>() + drops.at("many_keys").get<long>(), 1000);
}

// Where there is one core for all of a peer's threads, those that receive stand below the hand's.
TEST_F(HostileFloods, StatesOfAStrangerLeaveAHandOnOneCoreItsFrames) {
  cpu_set_t all;
  ASSERT_EQ(sched_getaffinity(0, sizeof all, &all), 0);
  int last = 0;
  for (int core = 0; core < CPU_SETSIZE; ++core) last = CPU_ISSET(core, &all) ? core : last;
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(last, &one);
  ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
  Program anna = Peer();
  ASSERT_EQ(sched_setaffinity(0, sizeof all, &all), 0);
  Program attacker = Attack("flood", "-", 1.5);
  ASSERT_TRUE(attacker.Says("joined")) << attacker.said();
  ASSERT_TRUE(anna.Says("you hold peg")) << anna.said();
  if (PriorityOf(anna, "haptic") == 0) GTEST_SKIP() << "real-time threads are refused here";
  for (const char* receives : {"recv", "recvUC"}) {
    EXPECT_LT(PriorityOf(anna, receives), PriorityOf(anna, "haptic")) << receives;
  }
  attacker.process().Signal(SIGUSR1);
  EXPECT_EQ(attacker.Wait(), 0);
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
  const nlohmann::json report = Report();
  const auto sent = std::stol(attacker.said().substr(attacker.said().find("sent ") + 5));
  EXPECT_GT(sent, 20'000);
  EXPECT_GT(report.at("drops").at("flood").get<long>(), sent / 4);
  EXPECT_LE(report.at("judged_missed").get<double>(),
            0.05 * report.at("judged_frames").get<double>());
}

TEST_F(HostileFloods, InventedNamesTakeNoMemoryAndFewLines) {
  Program anna = Peer();
  ASSERT_TRUE(anna.Says("is in session"));
  ExpectLittle(GrowthUnder("names", anna));
  EXPECT_GT(sent_, 5000);
  EXPECT_LE(static_cast<double>(lines_), 10 * (seconds_ + 1));
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
  EXPECT_GT(Report().at("drops").at("flood").get<long>(), 1000);
}

TEST_F(HostileFloods, AMembersInventedNamesTakeNoMemoryAndAreNotShown) {
  Program anna = SecuredPeer("ben", Role::kActive);
  ASSERT_TRUE(anna.Says("is in session"));
  ExpectLittle(GrowthUnder("names", anna, "ben", In("keys-ben").string()));
  EXPECT_GT(sent_, 2000);
  EXPECT_THAT(anna.said(), Not(HasSubstr("vic-")));
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
}

TEST_F(HostileFloods, PiecesOfASampleThatIsNeverWholeTakeNoMemory) {
  Program anna = Peer();
  ASSERT_TRUE(anna.Says("is in session"));
  ExpectLittle(GrowthUnder("pieces", anna));
  EXPECT_GT(sent_, 1000);
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
}

TEST_F(HostileFloods, InventedHostsFillNoController) {
  Program anna = Peer({"--control", session_});
  ASSERT_TRUE(anna.Says("is in session"));
  ExpectLittle(GrowthUnder("hosts", anna, ""));
  EXPECT_GT(sent_, 5000);
  EXPECT_THAT(anna.said(), HasSubstr("floods the controller"));
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
}

TEST_F(HostileFloods, InventedHostsFillNoControllerWhileNothingIsFreed) {
  Program anna = Peer({"--control", session_});
  ASSERT_TRUE(anna.Says("is in session"));
  stopped_thread_ = "gc";
  ExpectLittle(GrowthUnder("hosts", anna, ""));
  EXPECT_GT(sent_, 5000);
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
  EXPECT_GT(Report().at("drops").at("many_keys").get<long>(), 1000);
}

TEST_F(HostileFloods, AHostAttachesWhileInventedOnesCome) {
  Program anna = Peer({"--control", session_});
  ASSERT_TRUE(anna.Says("is in session"));
  Program attacker = Attack("hosts");
  ASSERT_TRUE(attacker.Says("joined")) << attacker.said();
  attacker.process().Signal(SIGUSR1);
  ASSERT_TRUE(anna.Says("floods the controller")) << anna.said();
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

TEST_F(HostileFloods, AnnouncementsOfInventedProgramsAreDroppedBeforeDdsAndToldOnce) {
  Program anna = Peer();
  ASSERT_TRUE(anna.Says("is in session"));
  ExpectLittle(GrowthUnder("packets", anna, ""));
  EXPECT_GT(sent_, 20'000);
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
  EXPECT_GT(Report().at("packets_refused").at("new_sender").get<long>(), 1000);
  int told = 0;
  for (const std::string& line : LinesOf(anna.said())) {
    told += line.find("announces more programs than there can be") != std::string::npos ? 1 : 0;
  }
  EXPECT_EQ(told, 1) << anna.said();
}

TEST_F(HostileFloods, AStrangersAnnouncementsTakeNoMemoryOfASecuredSession) {
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

TEST_F(HostileFloods, EndsOfInventedInstancesTakeNoMemoryAndHoldUpNobody) {
  Program anna = Peer();
  ASSERT_TRUE(anna.Says("is in session"));
  ExpectLittle(GrowthUnder("ends", anna));
  // the thread that hears them all goes on: another is seen to come
  Program ben = Program({TANDEM_PROGRAM, "watch", "--session", session_, "--interface", "lo",
                         "--domain", kDomain, "--name", "ben"},
                        In("ben"));
  EXPECT_TRUE(anna.Says("ben (viewer) joined", 20)) << anna.said();
  ben.process().Signal(SIGTERM);
  EXPECT_EQ(ben.Wait(), 0);
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
}

TEST_F(HostileFloods, WhoComesAndGoesIsToldOfOnceASecond) {
  Program anna = Peer();
  ASSERT_TRUE(anna.Says("is in session"));
  GrowthUnder("flap", anna);
  EXPECT_GT(lines_, 0U);
  EXPECT_LE(static_cast<double>(lines_), 2 * (seconds_ + 2));
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
}

TEST_F(HostileFloods, ANameThatIsNoTextLeavesReportAndLogReadable) {
  Program anna = Peer();
  ASSERT_TRUE(anna.Says("is in session"));
  Program attacker = Attack("name", "-", 0);
  // each byte that is no text, and each character that must not be shown, is one question mark
  ASSERT_TRUE(anna.Says("b???d")) << anna.said();
  attacker.process().Signal(SIGUSR1);
  EXPECT_EQ(attacker.Wait(), 0);
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
  EXPECT_TRUE(Report().is_object());
  EXPECT_THAT(anna.said(), Not(HasSubstr("\xff")));
}

TEST_F(HostileFloods, ManifestsOfInventedAuthorsFillNoRelay) {
  Program relay = Program(
      {TANDEM_PROGRAM, "relay", "--session", session_, "--interface", "lo", "--domain", kDomain},
      In("relay"));
  ASSERT_TRUE(relay.Says("relaying session"));
  ExpectLittle(GrowthUnder("scenes", relay, ""));
  EXPECT_GT(sent_, 2000);
  relay.process().Signal(SIGTERM);
  EXPECT_EQ(relay.Wait(), 0);
}

TEST_F(HostileFloods, PicturesOfInventedBodiesFillNoViewer) {
  Program watch = Program(
      {TANDEM_PROGRAM, "watch", "--session", session_, "--interface", "lo", "--domain", kDomain},
      In("watch"));
  ASSERT_TRUE(watch.Says("watching session"));
  ExpectLittle(GrowthUnder("views", watch, ""));
  EXPECT_GT(sent_, 2000);
  watch.process().Signal(SIGTERM);
  EXPECT_EQ(watch.Wait(), 0);
  for (const std::string& line : LinesOf(watch.said())) EXPECT_LT(line.size(), 2000U);
}

}  // namespace
}  // namespace tandem
