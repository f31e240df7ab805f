// A program of the tests' own (attacker.cpp) against whole programs of the product.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <random>
#include <sstream>
#include <thread>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "app/cli/child_processes.h"
#include "collab/dds/keys.h"
#include "tests/network/said_program.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;
using testing::LinesOf;
using ::testing::Not;
using testing::Program;

constexpr std::int64_t kMostGrowth = 16 * 1024 * 1024;  // bytes
constexpr double kFloodSeconds = 4;

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
  Program Attack(const std::string& mode, const std::string& keys = "-",
                 double seconds = kFloodSeconds) const {
    return Program({TANDEM_ATTACKER, session_, keys, "153", mode, std::to_string(seconds)},
                   In("attacker"));
  }
  nlohmann::json Report() const {
    std::ifstream stream(In("report"));
    return nlohmann::json::parse(stream, nullptr, false);
  }

  /// Lets the attack run against a program that is there already; returns by how many bytes that
  /// grew at the most, once it knew the attacker.
  std::int64_t GrowthUnder(const std::string& mode, Program& victim,
                           const std::string& keys = "-") {
    // all that starting takes is taken: for two seconds it has not grown any more
    std::int64_t before = victim.Memory();
    for (int quiet = 0, i = 0; quiet < 20 && i < 300; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      const std::int64_t now = victim.Memory();
      quiet = now > before + 65'536 ? 0 : quiet + 1;
      before = std::max(before, now);
    }
    EXPECT_GT(before, 0);
    Program attacker = Attack(mode, keys);
    if (mode != "packets") {
      EXPECT_TRUE(attacker.Says("joined"));
      for (int i = 0; i < 12; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
        before = std::max(before, victim.Memory());
      }
    }
    std::int64_t most = before;
    while (!attacker.process().Poll()) {
      most = std::max(most, victim.Memory());
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    EXPECT_THAT(attacker.said(), HasSubstr("sent "));
    sent_ = std::stol(attacker.said().substr(attacker.said().find("sent ") + 5));
    RecordProperty("sent", static_cast<int>(sent_));
    RecordProperty("growth_kb", static_cast<int>((most - before) / 1024));
    return most - before;
  }

  const TemporaryFolder folder_;
  const std::string session_;
  long sent_ = 0;
};

TEST_F(HostileFloods, StatesOfInventedBodiesTakeNoMemoryAreCountedAndTold) {
  Program anna = Peer();
  ASSERT_TRUE(anna.Says("is in session"));
  EXPECT_LE(GrowthUnder("keys", anna), kMostGrowth);
  EXPECT_GT(sent_, 20'000);
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
  const nlohmann::json drops = Report().at("drops");
  EXPECT_GT(drops.at("flood").get<long>() + drops.at("many_keys").get<long>(), sent_ / 4);
  EXPECT_THAT(anna.said(), HasSubstr("not heard for a second"));
}

TEST_F(HostileFloods, AMembersInventedBodiesTakeNoMoreThanAStrangers) {
  const std::filesystem::path keys = In("keys");
  ASSERT_TRUE(MakeSessionKeys(keys));
  ASSERT_TRUE(MakeMemberKeys(keys, "anna", Role::kActive, In("keys-anna")));
  ASSERT_TRUE(MakeMemberKeys(keys, "ben", Role::kActive, In("keys-ben")));
  Program anna = Peer({"--secure", In("keys-anna").string()});
  ASSERT_TRUE(anna.Says("is in session"));
  EXPECT_LE(GrowthUnder("keys", anna, In("keys-ben").string()), kMostGrowth);
  EXPECT_GT(sent_, 5'000);
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
  const nlohmann::json drops = Report().at("drops");
  EXPECT_GT(drops.at("flood").get<long>() + drops.at("many_keys").get<long>(), 1000);
}

TEST_F(HostileFloods, InventedViewersOfAViewersKeysTakeNoMemory) {
  const std::filesystem::path keys = In("keys");
  ASSERT_TRUE(MakeSessionKeys(keys));
  ASSERT_TRUE(MakeMemberKeys(keys, "anna", Role::kActive, In("keys-anna")));
  ASSERT_TRUE(MakeMemberKeys(keys, "vic", Role::kViewer, In("keys-vic")));
  Program anna = Peer({"--secure", In("keys-anna").string()});
  ASSERT_TRUE(anna.Says("is in session"));
  EXPECT_LE(GrowthUnder("lookers", anna, In("keys-vic").string()), kMostGrowth);
  EXPECT_GT(sent_, 2000);
  EXPECT_THAT(anna.said(), Not(HasSubstr("looker-")));
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
  const nlohmann::json drops = Report().at("drops");
  EXPECT_GT(drops.at("flood").get<long>() + drops.at("many_keys").get<long>(), 1000);
}

TEST_F(HostileFloods, AnnouncementsOfInventedProgramsAreDroppedBeforeDdsAndToldOnce) {
  Program anna = Peer();
  ASSERT_TRUE(anna.Says("is in session"));
  EXPECT_LE(GrowthUnder("packets", anna), kMostGrowth);
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
  EXPECT_LE(GrowthUnder("packets", anna), kMostGrowth);
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
  EXPECT_GT(Report().at("packets_refused").at("new_sender").get<long>(), 1000);
}

TEST_F(HostileFloods, EndsOfInventedInstancesTakeNoMemoryAndHoldUpNobody) {
  Program anna = Peer();
  ASSERT_TRUE(anna.Says("is in session"));
  EXPECT_LE(GrowthUnder("ends", anna), kMostGrowth);
  // the thread that hears them all goes on: another is seen to come
  Program ben = Program({TANDEM_PROGRAM, "watch", "--session", session_, "--interface", "lo",
                         "--name", "ben", "--seconds", "12"},
                        In("ben"));
  EXPECT_TRUE(anna.Says("ben (viewer) joined", 20)) << anna.said();
  EXPECT_EQ(ben.Wait(), 0);
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
}

TEST_F(HostileFloods, WhoComesAndGoesIsToldOfOnceASecond) {
  Program anna = Peer();
  ASSERT_TRUE(anna.Says("is in session"));
  const std::size_t before = LinesOf(anna.said()).size();
  GrowthUnder("flap", anna);
  const std::size_t during = LinesOf(anna.said()).size() - before;
  EXPECT_GT(during, 0U);
  EXPECT_LE(static_cast<double>(during), 2 * (kFloodSeconds + 2));
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
}

TEST_F(HostileFloods, ANameThatIsNoTextLeavesReportAndLogReadable) {
  Program anna = Peer();
  ASSERT_TRUE(anna.Says("is in session"));
  Program attacker = Attack("name", "-", 3);
  // each byte that is no text, and each character that must not be shown, is one question mark
  ASSERT_TRUE(anna.Says("b???d")) << anna.said();
  EXPECT_EQ(attacker.Wait(), 0);
  anna.process().Signal(SIGTERM);
  EXPECT_EQ(anna.Wait(), 0);
  EXPECT_TRUE(Report().is_object());
  EXPECT_THAT(anna.said(), Not(HasSubstr("\xff")));
}

TEST_F(HostileFloods, ManifestsOfInventedAuthorsFillNoRelay) {
  Program relay =
      Program({TANDEM_PROGRAM, "relay", "--session", session_, "--interface", "lo"}, In("relay"));
  ASSERT_TRUE(relay.Says("relaying session"));
  EXPECT_LE(GrowthUnder("scenes", relay), kMostGrowth);
  EXPECT_GT(sent_, 2000);
  relay.process().Signal(SIGTERM);
  EXPECT_EQ(relay.Wait(), 0);
}

TEST_F(HostileFloods, PicturesOfInventedBodiesFillNoViewer) {
  Program watch =
      Program({TANDEM_PROGRAM, "watch", "--session", session_, "--interface", "lo"}, In("watch"));
  ASSERT_TRUE(watch.Says("watching session"));
  EXPECT_LE(GrowthUnder("views", watch), kMostGrowth);
  EXPECT_GT(sent_, 2000);
  watch.process().Signal(SIGTERM);
  EXPECT_EQ(watch.Wait(), 0);
  for (const std::string& line : LinesOf(watch.said())) EXPECT_LT(line.size(), 2000U);
}

}  // namespace
}  // namespace tandem
