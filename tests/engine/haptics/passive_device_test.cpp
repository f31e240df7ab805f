#include "engine/haptics/passive_device.h"

#include <gtest/gtest.h>

namespace tandem {
namespace {

HandScript Shift() {
  HandScript script;
  script.X_BD.p = Vec3(0, 0, 0.05);
  script.waypoints = {{0, Vec3::Zero(), Quat::Identity()}, {1, Vec3(0.1, 0, 0), Quat::Identity()}};
  return script;
}

TEST(PassiveDevice, FollowsItsUserRegardlessOfForce) {
  const Pose X_WB0{Quat::Identity(), Vec3(1, 2, 3)};
  PassiveDevice device(Shift(), X_WB0);
  const Wrench push{Vec3(0, 0, 1), Vec3(-12, 3, 0)};
  device.Render(push);
  EXPECT_EQ(device.Read().X_WA.p, Vec3(1, 2, 3.05));  // not begun
  device.Start();
  for (int frame = 0; frame < 500; ++frame) device.Render(push);
  // half way in time, half way in space, at 15/8 of the mean speed of a minimum jerk
  EXPECT_NEAR(device.Read().X_WA.p.x(), 1.05, 1e-12);
  EXPECT_NEAR(device.Read().V_WA.v.x(), 0.1875, 1e-12);
  for (int frame = 0; frame < 600; ++frame) device.Render(push);
  EXPECT_EQ(device.Read().X_WA.p, Vec3(1.1, 2, 3.05));
  EXPECT_EQ(device.Read().V_WA.v.norm(), 0.0);
}

TEST(PassiveDevice, WithoutAScriptItStaysWhereTheBodyIs) {
  PassiveDevice device({}, {Quat::Identity(), Vec3(1, 2, 3)});
  device.Start();
  for (int frame = 0; frame < 100; ++frame) device.Render({Vec3::Zero(), Vec3(1, 1, 1)});
  EXPECT_EQ(device.Read().X_WA.p, Vec3(1, 2, 3));
}

}  // namespace
}  // namespace tandem
