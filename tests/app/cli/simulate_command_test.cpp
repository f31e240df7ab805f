#include <chrono>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/common/exit_codes.h"
#include "tests/app/cli/program_run.h"

namespace tandem {
namespace {

using testing::RunTandem;
using testing::Said;

TEST(SimulateCommand, DigestIsIndependentOfRepetitionAndThreads) {
  const Said one = RunTandem("simulate --first 3 --seeds 3 --threads 1 --json");
  const Said two = RunTandem("simulate --first 3 --seeds 3 --threads 3 --json");
  ASSERT_EQ(one.exit_code, kExitOk) << one.out << one.err;
  const auto a = nlohmann::json::parse(one.out);
  const auto b = nlohmann::json::parse(two.out);
  for (const char* const key : {"seeds", "broken", "wall_s", "simulated_peer_s", "happened"}) {
    EXPECT_TRUE(a.contains(key)) << key;
  }
  EXPECT_EQ(a["seeds"], 3);
  EXPECT_EQ(a["broken"], 0);
  EXPECT_GT(a["simulated_peer_s"], 50.0);
  EXPECT_EQ(a["digest"], b["digest"]);
  EXPECT_EQ(a["happened"], b["happened"]);
}

TEST(SimulateCommand, ReportsEachSeed) {
  const Said said = RunTandem("simulate --seed 3 --verbose");
  EXPECT_EQ(said.exit_code, kExitOk) << said.out;
  for (const char* const line : {" joins, object ", "is told: you hold", "longest round trip"}) {
    EXPECT_NE(said.out.find(line), std::string::npos) << line;
  }
}

TEST(SimulateCommand, HandsAreRepeatableAndNameTheActors) {
  const Said one = RunTandem("simulate --hands --seeds 2 --seconds 10 --threads 1 --json");
  const Said two = RunTandem("simulate --hands --seeds 2 --seconds 10 --threads 2 --json");
  ASSERT_EQ(one.exit_code, kExitOk) << one.out << one.err;
  const auto a = nlohmann::json::parse(one.out);
  EXPECT_EQ(a["broken"], 0);
  EXPECT_GE(a["simulated_s"], 10.0);
  EXPECT_GT(a["happened"]["requests"], 10);
  EXPECT_EQ(a["digest"], nlohmann::json::parse(two.out)["digest"]);
  const Said told = RunTandem("simulate --hands --seed 1 --seconds 10 --verbose");
  for (const char* const line : {" comes", ": grab ", " answers host-", "is told: "}) {
    EXPECT_NE(told.out.find(line), std::string::npos) << line;
  }
}

TEST(SimulateCommand, AcceptsDurationsForScenesAndHands) {
  for (const char* const wrong :
       {"--seeds 2 --seconds 20", "--hands --seconds 9", "--hands --scene ball_and_socket"}) {
    const Said said = RunTandem(std::string("simulate ") + wrong);
    EXPECT_EQ(said.exit_code, kExitUsage) << wrong;
    EXPECT_FALSE(said.err.empty()) << wrong;
  }
}

TEST(SimulateCommand, RefusesInvalidSeeds) {
  for (const char* const wrong : {"--seed -1", "--seed x", "--seeds 0", "--scene no_such_scene"}) {
    const Said said = RunTandem(std::string("simulate ") + wrong);
    EXPECT_NE(said.exit_code, kExitOk) << wrong;
    EXPECT_FALSE(said.err.empty()) << wrong;
  }
}

TEST(SimulateCommand, ReportsTheSpeedOfAScene) {
  const auto began = std::chrono::steady_clock::now();
  const Said said =
      RunTandem("simulate --scene " TANDEM_SCENES "/ball_and_socket.json --seconds 1.5 --json");
  const double wall_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  ASSERT_EQ(said.exit_code, kExitOk) << said.err;
  const auto figures = nlohmann::json::parse(said.out);
  EXPECT_EQ(figures["peers"], 2);
  EXPECT_NEAR(figures["simulated_s"], 1.5, 1e-6);
  // in contact for most of it
  EXPECT_GT(figures["contact_s"], 1.0);
  EXPECT_GT(figures["contact_points"], 100.0);
  // speed is that of this program's processor time, which cannot be longer than the run
  EXPECT_GT(figures["speed"].get<double>(), 1.5 / wall_s);
}

}  // namespace
}  // namespace tandem
