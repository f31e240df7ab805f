#include <chrono>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/common/exit_codes.h"
#include "tests/app/cli/program_run.h"

namespace tandem {
namespace {

using testing::ProgramOutput;
using testing::RunTandem;

TEST(SimulateCommand, DigestIsIndependentOfRepetitionAndThreads) {
  const ProgramOutput one = RunTandem("simulate --first 3 --seeds 3 --threads 1 --json");
  const ProgramOutput two = RunTandem("simulate --first 3 --seeds 3 --threads 3 --json");
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
  const ProgramOutput output = RunTandem("simulate --seed 3 --verbose");
  EXPECT_EQ(output.exit_code, kExitOk) << output.out;
  for (const char* const line : {" joins, object ", "is told: you hold", "longest round trip"}) {
    EXPECT_NE(output.out.find(line), std::string::npos) << line;
  }
}

TEST(SimulateCommand, HandsAreRepeatableAndNameTheActors) {
  const ProgramOutput one = RunTandem("simulate --hands --seeds 2 --seconds 10 --threads 1 --json");
  const ProgramOutput two = RunTandem("simulate --hands --seeds 2 --seconds 10 --threads 2 --json");
  ASSERT_EQ(one.exit_code, kExitOk) << one.out << one.err;
  const auto a = nlohmann::json::parse(one.out);
  EXPECT_EQ(a["broken"], 0);
  EXPECT_GE(a["simulated_s"], 10.0);
  EXPECT_GT(a["happened"]["requests"], 10);
  EXPECT_EQ(a["digest"], nlohmann::json::parse(two.out)["digest"]);
  const ProgramOutput reported = RunTandem("simulate --hands --seed 1 --seconds 10 --verbose");
  for (const char* const line : {" comes", ": grab ", " answers host-", "is told: "}) {
    EXPECT_NE(reported.out.find(line), std::string::npos) << line;
  }
}

TEST(SimulateCommand, AcceptsDurationsForScenesAndHands) {
  for (const char* const wrong :
       {"--seeds 2 --seconds 20", "--hands --seconds 9", "--hands --scene ball_and_socket"}) {
    const ProgramOutput output = RunTandem(std::string("simulate ") + wrong);
    EXPECT_EQ(output.exit_code, kExitUsage) << wrong;
    EXPECT_FALSE(output.err.empty()) << wrong;
  }
}

TEST(SimulateCommand, RefusesInvalidSeeds) {
  for (const char* const wrong : {"--seed -1", "--seed x", "--seeds 0", "--scene no_such_scene"}) {
    const ProgramOutput output = RunTandem(std::string("simulate ") + wrong);
    EXPECT_NE(output.exit_code, kExitOk) << wrong;
    EXPECT_FALSE(output.err.empty()) << wrong;
  }
}

TEST(SimulateCommand, ReportsTheSpeedOfAScene) {
  const auto began = std::chrono::steady_clock::now();
  const ProgramOutput output =
      RunTandem("simulate --scene " TANDEM_SCENES "/ball_and_socket.json --seconds 1.5 --json");
  const double wall_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  const auto figures = nlohmann::json::parse(output.out);
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
