#include "tests/soak/soak_judgement.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/recording/trace_file.h"
#include "tests/support/scratch_folder.h"

// The life of a sound peer, and faults that are injected into it: each must be found.

namespace tandem::testing {
namespace {

using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr SoakBounds kMinute{.settle_s = 20};

class SoakJudgement : public ::testing::Test {
 protected:
  SoakJudgement() {
    life_.name = "anna-1";
    life_.ended_s = 60;
    life_.stopped_s = 2;
    life_.took_to_end_s = 0.1;
    life_.exit_code = 0;
    life_.said_goodbye = true;
    life_.most_lines_per_s = 2;
    life_.report = folder_.path() / "report";
    for (int i = 0; i < 60; ++i) {
      // memory is taken in the first seconds
      const std::int64_t memory = 100'000'000 + std::min(i, 10) * 1'000'000;
      life_.footprints.push_back({.at_s = 1.0 * i, .memory = memory, .files = 20});
    }
    report_ = {{"felt", {{"peak_N", 3.0}, {"peak_Nm", 0.1}, {"peak_step_N", 0.5}}},
               {"contact_share", 0.4},
               {"delay_ms", 51.0},
               {"missed", 2012},
               {"device_times", nullptr},
               {"safety", {{"passivity", nullptr}, {"stops", 0}}}};
    trace_.resize(100);
  }

  std::vector<std::string> Faults() {
    folder_.Write("report", report_.dump());
    TraceFile file(life_.report.string() + ".trace", [this] {
      return std::span<const TraceSample>(trace_);
    });
    EXPECT_TRUE(file.Close());
    return FaultsOf(life_, kMinute);
  }

  const ScratchFolder folder_;
  SoakLife life_;
  json report_;
  std::vector<TraceSample> trace_;
};

TEST_F(SoakJudgement, HealthyLifeHasNoFault) {
  EXPECT_THAT(Faults(), IsEmpty());
  const json row = AsJson(life_, kMinute);
  EXPECT_EQ(row.at("memory").at("growth_bytes"), 0);
  EXPECT_EQ(row.at("delay_ms"), 51.0);
  EXPECT_EQ(row.at("missed_beside_stops"), 12.0);
}

TEST_F(SoakJudgement, DetectsMemoryGrowth) {
  for (Footprint& one : life_.footprints) {
    if (one.at_s > 30) one.memory += static_cast<std::int64_t>(300'000 * (one.at_s - 30));
  }
  EXPECT_THAT(Faults(), ElementsAre(HasSubstr("it grew by ")));
}

TEST_F(SoakJudgement, DetectsDescriptorLeaks) {
  life_.footprints.back().files = 29;
  EXPECT_THAT(Faults(), ElementsAre(HasSubstr("files open")));
}

TEST_F(SoakJudgement, ShortLifeIsNotJudgedByMemory) {
  life_.footprints.resize(35);
  EXPECT_FALSE(TrendOf(life_, kMinute.settle_s));
}

TEST_F(SoakJudgement, DetectsNonFiniteNumbers) {
  report_["frame_cpu_us"]["p99"] = std::nan("");  // JSON has no such number
  EXPECT_THAT(Faults(), ElementsAre(HasSubstr("no number in its report: /frame_cpu_us/p99")));
  report_.erase("frame_cpu_us");
  trace_[42].V_WB.v.y() = std::nan("");
  EXPECT_THAT(Faults(), ElementsAre(HasSubstr("frame 42 of its trace")));
  trace_[42] = {};
  life_.not_finite = "tandem: ben-1 52 ms 80 N/m nan N";
  EXPECT_THAT(Faults(), ElementsAre(HasSubstr("nan N")));
}

TEST_F(SoakJudgement, DetectsExcessForceAndMissingContactOrDelay) {
  report_["felt"]["peak_N"] = 12.1;
  report_["contact_share"] = 0;
  report_["delay_ms"] = 0.1;
  EXPECT_THAT(Faults(), ElementsAre(HasSubstr("felt more than the limits"), HasSubstr("no contact"),
                                    HasSubstr("a delay of 0.1 ms")));
}

TEST_F(SoakJudgement, DetectsLateOrWrongExitAndMissingGoodbye) {
  life_.took_to_end_s = 1.2;
  life_.exit_code = 139;
  life_.said_goodbye = false;
  EXPECT_THAT(Faults(),
              ElementsAre(HasSubstr("it ended with 139 for 0"), HasSubstr("1.200 s to end"),
                          HasSubstr("nobody heard its goodbye")));
}

// A recording that could not be finished is told by the exit code: docs/architecture.md.
TEST_F(SoakJudgement, FullDiskMustBeReportedAtTheEnd) {
  life_.disk_full = true;
  EXPECT_THAT(Faults(), ElementsAre(HasSubstr("it ended with 0 for 3")));
  life_.exit_code = 3;
  EXPECT_THAT(Faults(), IsEmpty());
}

TEST_F(SoakJudgement, DetectsMissingReportOrTrace) {
  EXPECT_THAT(FaultsOf(life_, kMinute), ElementsAre(HasSubstr("no report")));
  trace_.clear();
  EXPECT_THAT(Faults(), ElementsAre(HasSubstr("its hand never began")));
}

TEST_F(SoakJudgement, DetectsExcessiveOutput) {
  life_.most_lines_per_s = 14;
  EXPECT_THAT(Faults(), ElementsAre(HasSubstr("14.000 lines a second")));
}

TEST_F(SoakJudgement, KilledProcessIsJudgedByMemoryAndLinesOnly) {
  life_.killed = true;
  life_.exit_code.reset();
  life_.said_goodbye = false;
  EXPECT_THAT(FaultsOf(life_, kMinute), IsEmpty());
}

}  // namespace
}  // namespace tandem::testing
