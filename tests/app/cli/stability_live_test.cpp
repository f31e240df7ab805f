#include <algorithm>
#include <cmath>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/exit_codes.h"
#include "tests/app/cli/program_run.h"
#include "tests/support/tap_hub_here.h"

// `tandem stability live`, as a program: peers are processes, in real time.

namespace tandem {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using testing::RunTandem;
using testing::Said;

double LiveFigure(const json& out, const std::string& name) {
  for (const json& row : out.at("comparison")) {
    if (row.at("figure") == name) return row.at("live").get<double>();
  }
  return std::nan("");
}

// The bar that an idle machine meets is 10 %; a busy one makes a loop older, not shorter.
TEST(StabilityLive, RealPeersDoWhatVirtualTimeSays) {
  const ScratchFolder scratch;
  const auto file = scratch.Write("case.json", R"({"name": "a move", "hands": ["relaxed"],
      "motion": "move", "delay_s": 0.1, "seconds": 5, "law": {"name": "p+d", "gate": false}})");
  const Said said = RunTandem("stability live --json --bar 0.5 --keep " +
                              (scratch.path() / "kept").string() + " " + file.string());
  ASSERT_EQ(said.exit_code, kExitOk) << said.err;
  const json out = json::parse(said.out);
  EXPECT_EQ(out.at("within"), true);
  EXPECT_EQ(out.at("metrics_live").at("frames"), 5000);
  // a loop is two delays, and whatever else
  EXPECT_GT(LiveFigure(out, "loop age"), 200);
  EXPECT_GT(LiveFigure(out, "divergence at the most"), 30);
  // what was kept can be replayed, with the gate off
  const Said replayed =
      RunTandem("replay --json " + (scratch.path() / "kept" / "user-0.recording").string());
  EXPECT_EQ(replayed.exit_code, kExitOk) << replayed.err;
}

// The same where packets are late, not samples: discovery and answers too.
TEST(StabilityLive, ANetworkOfRealPacketsHeldBackDoesAsTheConditionerDoes) {
  if (const char* lacks = testing::WhyNoTapHub()) GTEST_SKIP() << lacks;
  const ScratchFolder scratch;
  const auto file = scratch.Write("case.json", R"({"hands": ["relaxed"], "motion": "move",
      "delay_s": 0.06, "seconds": 5, "law": {"name": "p+d"}})");
  const Said said = RunTandem("stability live --json --bar 0.5 --tap " + file.string());
  ASSERT_EQ(said.exit_code, kExitOk) << said.err;
  const json out = json::parse(said.out);
  EXPECT_EQ(out.at("network"), "TAP hub");
  EXPECT_GT(LiveFigure(out, "loop age"), 120);
  EXPECT_GT(LiveFigure(out, "divergence at the most"), 20);
}

// By 0.2 T one way and 1.8 T the other, and with gains of one's own.
TEST(StabilityLive, DelaysThatDifferByDirectionAndOwnGainsReachThePeers) {
  const ScratchFolder scratch;
  const auto file = scratch.Write("case.json", R"({"hands": ["relaxed"], "motion": "still",
      "delay_s": 0.05, "network": "asymmetric", "seconds": 4,
      "law": {"name": "constant", "limits": {"constant_stiffness": 77, "constant_damping": 10}}})");
  const Said said = RunTandem("stability live --json --bar 10 --keep " +
                              (scratch.path() / "kept").string() + " " + file.string());
  ASSERT_EQ(said.exit_code, kExitOk) << said.err;
  const json out = json::parse(said.out);
  EXPECT_NEAR(LiveFigure(out, "stiffness at the end"), 77, 1e-6);
  const auto delay_in = [&](const char* plan) {
    std::ifstream stream(scratch.path() / "kept" / plan);
    return json::parse(stream).at("links")[0].at("steps")[0].at("delay_ms").get<double>();
  };
  EXPECT_NEAR(delay_in("user-1.plan.json"), 10, 1e-9);
  EXPECT_NEAR(delay_in("user-0.plan.json"), 90, 1e-9);
}

// 20 ms, then 120 ms, and a law of half its stiffness: 0.5 x 1.2 (B/te + B^2/3m) at the end.
TEST(StabilityLive, DelaysThatChangeAndARatioOfTheLawReachThePeers) {
  const ScratchFolder scratch;
  const auto file = scratch.Write("case.json", R"({"hands": ["relaxed"], "motion": "kick",
      "delay_s": 0.02, "network": {"schedule": [{"at_s": 2, "delay_s": 0.12}]}, "seconds": 5,
      "law": {"name": "p+dd", "ratio": 0.5}})");
  const Said said = RunTandem("stability live --json --bar 10 " + file.string());
  ASSERT_EQ(said.exit_code, kExitOk) << said.err;
  const json out = json::parse(said.out);
  EXPECT_GT(LiveFigure(out, "loop age"), 240);
  EXPECT_LT(LiveFigure(out, "loop age"), 300);
  const auto stiffness = [](double loop_s) {
    const double te = 0.5 * (1.1 * loop_s + 0.005);
    return 0.5 * 1.2 * (10 / te + 100 / (3 * 1.5));
  };
  EXPECT_LT(LiveFigure(out, "stiffness at the end"), stiffness(0.24));
  EXPECT_GT(LiveFigure(out, "stiffness at the end"), stiffness(0.32));
}

TEST(StabilityLive, CasesThatNoPeerCanRunAreRefusedInALine) {
  const ScratchFolder scratch;
  const auto file = scratch.Write("case.json", R"({"law": {"exchange_forces": true}})");
  const auto outage =
      scratch.Write("outage.json", R"({"network": {"schedule": [{"at_s": 3, "cut": true}]}})");
  const auto jump =
      scratch.Write("jump.json", R"({"network": {"schedule": [{"at_s": 3, "delay_s": 0.3}]}})");
  for (const auto& [arguments, why] :
       {std::pair(file.string(), "peers never exchange forces"),
        std::pair(outage.string(), "an outage ends links"),
        std::pair("--tap " + jump.string(), "packets' delays do not change: leave --tap out")}) {
    const Said said = RunTandem("stability live " + arguments);
    EXPECT_EQ(said.exit_code, kExitUsage);
    EXPECT_THAT(said.err, HasSubstr(std::string("cannot be run live: ") + why));
    EXPECT_EQ(std::count(said.err.begin(), said.err.end(), '\n'), 1) << said.err;
  }
}

}  // namespace
}  // namespace tandem
