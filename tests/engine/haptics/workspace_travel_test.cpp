// Scale enters the limit on travel (paper §5): a scaled hand that is faster than its body may go
// feels the coupling, and the body does not jump.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "engine/haptics/workspace.h"
#include "engine/world/world.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

/// A handle that goes down at a metre a second, and stays.
class FallingDevice : public Device {
 public:
  void Start() noexcept override {}
  Anchor Read() noexcept override {
    Anchor handle;
    handle.X_WA.p.z() = -std::min(1e-3 * frame, way);
    if (1e-3 * frame++ < way) handle.V_WA.v.z() = -1;
    return handle;
  }
  void Render(const Wrench&) noexcept override {}
  double way = 0.005;  // m
  int frame = 0;
};

TEST(WorkspaceTravel, ScaledHandBeyondTheTravelLimitFeelsSmoothCoupling) {
  // a box of 20 mm, 10 mm above a plate whose top is at -20 mm
  const auto model = testing::MakeWorldModel(
      {{testing::At(testing::Box(Vec3(0.1, 0.1, 0.02)), Vec3(0, 0, -0.03)), true},
       {testing::Box(Vec3(0.02, 0.02, 0.02))}},
      testing::kVoxel);
  World world(model);
  FallingDevice device;
  Workspace workspace(device, {.scale = 20});  // 20 m/s in the scene, 100 mm down: into the plate
  workspace.Start();
  StepInputs inputs = testing::FreeInputs(*model);
  Vec3 last = world.state(0).X_WB.p;
  double lead = 0;
  double force = 0;
  int limited = 0;
  for (int i = 0; i < 1000; ++i) {
    const Anchor handle = workspace.Read();
    inputs.hand = testing::HandTo(*model, 0, handle.X_WA);
    inputs.hand.goal.V_WA = handle.V_WA;
    const StepReport& report = world.Step(inputs);
    const Vec3 p = world.state(0).X_WB.p;
    // half a voxel a frame, however fast the hand
    ASSERT_LE((p - last).norm(), 0.5 * testing::kVoxel + 1e-9) << i;
    limited += (report.flags & StepReport::kTravelLimited) != 0 ? 1 : 0;
    // half a voxel deep at the most
    ASSERT_GE(p.z(), -0.01 - 0.5 * testing::kVoxel) << i;
    lead = std::max(lead, p.z() - handle.X_WA.p.z());
    force = std::max(force, report.hand_B_W.f.norm());
    last = p;
  }
  EXPECT_GT(limited, 3);
  EXPECT_GT(lead, 0.08);  // the handle is far ahead
  EXPECT_GT(force, 10);   // and the coupling says so
  EXPECT_NEAR(last.z(), -0.01, testing::kVoxel);
}

}  // namespace
}  // namespace tandem
