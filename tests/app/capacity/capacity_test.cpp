#include "app/capacity/capacity.h"

#include <vector>

#include <gtest/gtest.h>

#include "app/bench/measure/paired_ratios.h"
#include "engine/base/units.h"
#include "engine/realtime/clock.h"
#include "engine/world/world.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

// Tests what a peer measures of its machine before it begins. Times are processor times of one
// thread. Two times are compared only if they were taken in the same second.

namespace tandem {
namespace {

using testing::At;
using testing::Box;
using testing::FreeInputs;
using testing::HandTo;
using testing::MakeWorldModel;
using testing::Sphere;

constexpr double kBallVoxel = 0.0005;

/// Returns a model of a ball of some 30,000 points over a plate.
std::shared_ptr<const WorldModel> BallOverPlate(ContactModel contact = ContactModel::kRefined) {
  return MakeWorldModel({{At(Box(Vec3(0.08, 0.08, 0.01)), Vec3(0, 0, -0.005)), true},
                         {At(Sphere(0.02, 5), Vec3(0, 0, 0.021))}},
                        kBallVoxel, contact);
}

/// Returns the thread's processor time that `work` takes, s.
template <class Work>
double CpuSeconds(const Work& work) {
  const std::int64_t begin = MachineClock().ThreadCpuNs();
  work();
  return ToSeconds(MachineClock().ThreadCpuNs() - begin);
}

TEST(Capacity, IsProportionalToTheFrameTime) {
  const auto model = BallOverPlate();
  std::vector<double> ratios;
  for (int round = 0; round < 5; ++round) {
    const double one = MeasureCapacity(*model, 200e-6).tests;
    ratios.push_back(MeasureCapacity(*model, 800e-6).tests / one);
  }
  EXPECT_NEAR(MedianOf(ratios), 4.0, 1.0);
}

TEST(Capacity, IsNeverLessThanAThousandTests) {
  EXPECT_EQ(MeasureCapacity(*BallOverPlate(), 1e-9).tests, 1000.0);
}

// A frame that tests N points should take N / capacity of the given time. Without coherence every
// frame tests every point, so that there is little else in it.
TEST(Capacity, ReportsTheTimeOfPointTestFrames) {
  kHapticThread.Enter();
  const auto model = BallOverPlate(ContactModel::kPlain);
  World world(model, {.experiments = {.coherence = false, .chunks = false, .drift = false}});
  StepInputs inputs = FreeInputs(*model);
  std::vector<double> ratios;  // time that frames took / time promised
  for (int round = 0; round < 9; ++round) {
    const FrameCapacity capacity = MeasureCapacity(*model, kFrameBudget);
    double tested = 0;
    const double took_s = CpuSeconds([&] {
      for (int frame = 0; frame < 50; ++frame) {
        const Quat ahead = RotationBy(Vec3(0.6, 0.4, 0)) * world.state(0).X_WB.q;
        inputs.hand = HandTo(*model, 0, {ahead, model->bodies[0].X_WB0.p});
        tested += world.Step(inputs).tests.tests();
      }
    });
    ASSERT_GT(tested, 100 * 1000);
    ratios.push_back(took_s / (kFrameBudget * tested / capacity.tests));
  }
  RecordProperty("ratio", std::to_string(MedianOf(ratios)));
  EXPECT_GT(MedianOf(ratios), 0.33);
  EXPECT_LT(MedianOf(ratios), 3.0);
}

// The same holds in the refined model, whose frames look up features, and push some of them.
TEST(Capacity, ReportsTheTimeOfFeatureFrames) {
  kHapticThread.Enter();
  const auto model = BallOverPlate();
  World world(model, {.experiments = {.coherence = false, .chunks = false}});
  StepInputs inputs = FreeInputs(*model);
  std::vector<double> ratios;
  for (int round = 0; round < 9; ++round) {
    const FrameCapacity capacity = MeasureCapacity(*model, kFrameBudget);
    double worth = 0;  // work of the frames, in tests
    const double took_s = CpuSeconds([&] {
      for (int frame = 0; frame < 200; ++frame) {
        const Quat ahead = RotationBy(Vec3(0.6, 0.4, 0)) * world.state(0).X_WB.q;
        inputs.hand = HandTo(*model, 0, {ahead, Vec3(0, 0, 0.0198)});
        const StepReport& report = world.Step(inputs);
        worth += report.tests.tests() + capacity.query_price * report.exact_queries;
      }
    });
    ratios.push_back(took_s / (kFrameBudget * worth / capacity.tests));
  }
  RecordProperty("ratio", std::to_string(MedianOf(ratios)));
  EXPECT_GT(MedianOf(ratios), 0.33);
  EXPECT_LT(MedianOf(ratios), 3.0);
}

// There are no exact queries in the plain model: none is measured.
TEST(Capacity, HasNoMeasuredQueryPriceInThePlainModel) {
  const FrameCapacity capacity =
      MeasureCapacity(*BallOverPlate(ContactModel::kPlain), kFrameBudget);
  EXPECT_EQ(capacity.query_price, kDefaultQueryPrice);
  EXPECT_GT(capacity.tests, 1000.0);
}

TEST(Capacity, IsTheDefaultWithoutMeasurableContact) {
  EXPECT_EQ(MeasureCapacity(WorldModel{}, kFrameBudget).tests, kDefaultCapacity);
}

}  // namespace
}  // namespace tandem
