#include <algorithm>
#include <cmath>
#include <filesystem>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/common/exit_codes.h"
#include "collab/lab/case/case_file.h"
#include "collab/lab/case/case_parts.h"
#include "collab/lab/run/recorded_run.h"
#include "tests/app/cli/program_run.h"
#include "tests/support/tap_hub_here.h"

// Tests `tandem stability live` as a program: peers are processes, in real time.

namespace tandem {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using testing::ProgramOutput;
using testing::RunTandem;

double LiveFigure(const json& out, const std::string& name) {
  for (const json& row : out.at("comparison")) {
    if (row.at("figure") == name) return row.at("live").get<double>();
  }
  return std::nan("");
}

// The bar that an idle machine meets is 10 %; a busy one makes a loop older, not shorter.
TEST(StabilityLive, RealPeersMatchVirtualTime) {
  const ScratchFolder scratch;
  const auto file = scratch.Write("case.json", R"({"name": "a move", "hands": ["relaxed"],
      "motion": "move", "delay_s": 0.1, "seconds": 5, "law": {"name": "p+d", "gate": false}})");
  const ProgramOutput output = RunTandem("stability live --json --bar 0.5 --keep " +
                                         (scratch.path() / "kept").string() + " " + file.string());
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  const json out = json::parse(output.out);
  EXPECT_EQ(out.at("within"), true);
  EXPECT_EQ(out.at("metrics_live").at("frames"), 5000);
  // a loop is two delays, and some more
  EXPECT_GT(LiveFigure(out, "loop age"), 200);
  EXPECT_GT(LiveFigure(out, "divergence at the most"), 30);
  // the kept recordings can be replayed, with the gate off
  const ProgramOutput replayed =
      RunTandem("replay --json " + out.at("kept").get<std::string>() + "/user-0.recording");
  EXPECT_EQ(replayed.exit_code, kExitOk) << replayed.err;
}

// The same holds where packets are late instead of samples: discovery and answers are late too.
TEST(StabilityLive, RealPacketDelayMatchesTheConditioner) {
  if (const char* lacks = testing::WhyNoTapHub()) GTEST_SKIP() << lacks;
  const ScratchFolder scratch;
  const auto file = scratch.Write("case.json", R"({"hands": ["relaxed"], "motion": "move",
      "delay_s": 0.06, "seconds": 5, "law": {"name": "p+d"}})");
  const ProgramOutput output = RunTandem("stability live --json --bar 0.5 --tap " + file.string());
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  const json out = json::parse(output.out);
  EXPECT_EQ(out.at("network"), "TAP hub");
  EXPECT_GT(LiveFigure(out, "loop age"), 120);
  EXPECT_GT(LiveFigure(out, "divergence at the most"), 20);
}

/// Returns when each user first moves at 1 mm/s by its recording, s from when all loops are closed.
std::vector<double> Begins(const std::filesystem::path& kept, const LabCase& test) {
  const Result<LabScene> scene = LoadLabScene(test, TANDEM_SCENES "/stability");
  EXPECT_TRUE(scene) << scene.error().what;
  std::vector<double> begins(test.users, std::nan(""));
  const Result<RecordedRun> run = MeterRecordings(
      {kept / "user-0.recording", kept / "user-1.recording"}, FittedTo(scene->inertia(), test),
      *scene, [&](double t_s, std::span<const UserFrame> users) {
        for (std::size_t user = 0; user < users.size(); ++user) {
          const bool moves = users[user].state.V_WB.v.norm() > 1e-3;
          if (moves && std::isnan(begins[user])) begins[user] = t_s;
        }
      });
  EXPECT_TRUE(run) << run.error().what;
  return begins;
}

// Delays are 0.2 T one way and 1.8 T the other, and gains are the user's own. The second hand feels
// the knock 20 ms after the first, and a loop is 200 ms.
TEST(StabilityLive, DelaysThatDifferByDirectionAndOwnGainsReachThePeers) {
  const ScratchFolder scratch;
  const auto file = scratch.Write("case.json", R"({"hands": ["relaxed"], "motion": "kick",
      "delay_s": 0.1, "network": "asymmetric", "seconds": 4,
      "law": {"name": "constant", "limits": {"constant_stiffness": 77, "constant_damping": 10}}})");
  const ProgramOutput output = RunTandem("stability live --json --bar 0.5 --keep " +
                                         (scratch.path() / "kept").string() + " " + file.string());
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  const json out = json::parse(output.out);
  EXPECT_NEAR(LiveFigure(out, "stiffness at the end"), 77, 1e-6);
  EXPECT_GT(LiveFigure(out, "loop age"), 200);
  EXPECT_LT(LiveFigure(out, "loop age"), 260);
  // 77 N/m bring 1.2 kg to 1 mm/s within another 25 ms; a way of 180 ms would take longer than both
  const std::vector<double> begins = Begins(out.at("kept").get<std::string>(), *LoadCase(file));
  EXPECT_GE(begins[1] - begins[0], 0.02);
  EXPECT_LT(begins[1] - begins[0], 0.1);
}

// The delay is 20 ms, then 120 ms, and the law has half its stiffness: 0.5 x 1.2 (B/te + B^2/3m) at
// the end.
TEST(StabilityLive, DelaysThatChangeAndARatioOfTheLawReachThePeers) {
  const ScratchFolder scratch;
  const auto file = scratch.Write("case.json", R"({"hands": ["relaxed"], "motion": "kick",
      "delay_s": 0.02, "network": {"schedule": [{"at_s": 2, "delay_s": 0.12}]}, "seconds": 5,
      "law": {"name": "p+dd", "ratio": 0.5}})");
  const ProgramOutput output = RunTandem("stability live --json --bar 0.5 " + file.string());
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  const json out = json::parse(output.out);
  EXPECT_GT(LiveFigure(out, "loop age"), 240);
  EXPECT_LT(LiveFigure(out, "loop age"), 300);
  const auto stiffness = [](double loop_s) {
    const double te = 0.5 * (1.1 * loop_s + 0.005);
    return 0.5 * 1.2 * (10 / te + 100 / (3 * 1.5));
  };
  EXPECT_LT(LiveFigure(out, "stiffness at the end"), stiffness(0.24));
  EXPECT_GT(LiveFigure(out, "stiffness at the end"), stiffness(0.32));
}

TEST(StabilityLive, ImpossibleCasesAreRefusedInOneLine) {
  const ScratchFolder scratch;
  const auto file = scratch.Write("case.json", R"({"law": {"exchange_forces": true}})");
  const auto outage =
      scratch.Write("outage.json", R"({"network": {"schedule": [{"at_s": 3, "cut": true}]}})");
  const auto jump =
      scratch.Write("jump.json", R"({"network": {"schedule": [{"at_s": 3, "delay_s": 0.3}]}})");
  for (const auto& [arguments, why] :
       {std::pair(file.string(), "live peers never exchange forces"),
        std::pair(outage.string(), "a live peer cannot simulate an outage"),
        std::pair("--tap " + jump.string(),
                  "--tap: the delays of real packets cannot change: leave --tap out")}) {
    const ProgramOutput output = RunTandem("stability live " + arguments);
    EXPECT_EQ(output.exit_code, kExitUsage);
    EXPECT_THAT(output.err, HasSubstr(std::string("cannot run live: ") + why));
    EXPECT_EQ(std::count(output.err.begin(), output.err.end(), '\n'), 1) << output.err;
  }
}

}  // namespace
}  // namespace tandem
