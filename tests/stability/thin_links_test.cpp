#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "collab/lab/case/case_file.h"
#include "collab/lab/case/case_parts.h"
#include "collab/lab/run/case_run.h"
#include "collab/lab/sweep/random_cells.h"
#include "collab/lab/sweep/random_verdict.h"

// Tests links over which little comes: long delays, few samples a second, bursts that take many.
// Hands hold a part apart over them.
namespace tandem {
namespace {

const std::filesystem::path kScenes = std::filesystem::path(TANDEM_SCENES) / "stability";

constexpr const char* kBursts =
    R"("network": {"jitter_ms": 45, "burst_enter": 0.01, "burst_leave": 0.08, "burst_loss": 0.9})";

CaseResult RunText(const std::string& text) {
  const Result<LabCase> test = ParseCase(text, "case");
  EXPECT_TRUE(test) << test.error().what;
  const LabScene scene = *LoadLabScene(*test, kScenes);
  return RunCase(FittedTo(scene.inertia(), *test), scene);
}

void ExpectAtRest(const CaseResult& run) {
  ASSERT_FALSE(run.fault) << run.fault->what;
  EXPECT_EQ(run.verdict, Verdict::kStable) << run.metrics.growth;
  EXPECT_LE(run.metrics.generated_J, 1e-3);
  EXPECT_LT(run.metrics.tail_rms, 0.5e-3);
}

// The links are more than 2.4 s old at times. Such a link is softer, and does not fall to nothing.
TEST(ThinLinks, KeepTheirStiffnessThroughBurstsAtOneSecondOfDelay) {
  for (const char* hands : {R"(["off"])", R"(["heavy"])"}) {
    for (const char* motion : {"kick", "move"}) {
      for (int seed = 1; seed <= 3; ++seed) {
        SCOPED_TRACE(std::string(hands) + " " + motion + " " + std::to_string(seed));
        const CaseResult run = RunText(std::string(R"({"hands": )") + hands + R"(, "motion": ")" +
                                       motion + R"(", "delay_s": 1.1, "publish_hz": 37, )" +
                                       kBursts + R"(, "seed": )" + std::to_string(seed) + "}");
        ExpectAtRest(run);
        EXPECT_GT(run.metrics.stiffness, 20) << "N/m at the end";
        EXPECT_LT(run.metrics.peak_apart, 0.21);
      }
    }
  }
}

TEST(ThinLinks, KeepTheirStiffnessAmongFivePeers) {
  const CaseResult run = RunText(
      std::string(
          R"({"users": 5, "hands": ["heavy"], "delay_s": 0.6, "publish_hz": 37, "seed": 2, )") +
      kBursts + "}");
  ExpectAtRest(run);
  EXPECT_GT(run.metrics.stiffness, 7) << "N/m of each of four";
}

// The stiffness says where the part is that two hands pull apart, and the network moves the delay
// that the stiffness is made for.
TEST(ThinLinks, DoNotMoveAPartUnderOpposingForces) {
  const std::string heavy = R"({"mass_kg": 3, "damping_Ns_m": 0.7})";
  for (const std::string line :
       {R"("delay_s": 0.03, "publish_hz": 1000)", R"("delay_s": 0.3, "publish_hz": 120)",
        R"("delay_s": 0.9, "publish_hz": 60)"}) {
    for (const char* users : {"2", "3"}) {
      SCOPED_TRACE(line + " " + users);
      ExpectAtRest(RunText(R"({"scene": "off_centre", "motion": "hold", "users": )" +
                           std::string(users) + R"(, "hands": [)" + heavy + R"(, "firm"], )" +
                           line + ", " + kBursts + "}"));
    }
  }
}

void ExpectCalm(std::uint64_t first, std::size_t count) {
  RandomJudge judge(first);
  for (const SweepCell& cell : RandomCells(first, count)) {
    const LabCase test = *ParseCase(cell.case_json, "cell");
    const LabScene scene = *LoadLabScene(test, kScenes);
    judge.See(cell, RunRandomCase(FittedTo(scene.inertia(), test), scene));
  }
  const RandomSummary summary = judge.Finish();
  EXPECT_EQ(summary.cells, count);
  for (const RandomRecord& record : summary.worst) {
    ADD_FAILURE() << record.case_json << ": " << record.reasons.at(0);
  }
}

// The cases are a few of those that `tandem stability random` draws. presets.sh runs a thousand.
TEST(RandomCases, AreStableUnderTheDefaultLaw) {
  ExpectCalm(1, 12);
}

// Five users at 0.8 s and 15 samples a second. Bursts of loss are as long as the loop, and a soft
// hand holds the part apart from the others.
TEST(RandomCases, SoftHandHoldsAPartStillThroughLongSilences) {
  ExpectCalm(5157, 1);
}

// Two users are torn apart by a wall and meet again with an empty tank at one end. A link of no
// stiffness needs no reserve for the way of its copy, so it rises.
TEST(RandomCases, LinkStiffnessRecoversWithAnEmptyEnergyTank) {
  ExpectCalm(767, 1);
}

// A hand without a spring presses a ball into its socket. Contact alone would turn it on and on.
TEST(RandomCases, PressedBallComesToRestInItsSocket) {
  ExpectCalm(9455, 1);
}

}  // namespace
}  // namespace tandem
