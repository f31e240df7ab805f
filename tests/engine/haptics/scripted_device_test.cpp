#include "engine/haptics/scripted_device.h"

#include <gtest/gtest.h>

namespace tandem {
namespace {

HandScript Lift() {
  HandScript script;
  script.X_BD.p = Vec3(0.05, 0, 0);
  script.waypoints = {{0, Vec3::Zero(), Quat::Identity()},
                      {1.0, Vec3(0, 0, 0.1), RotationBy(Vec3(0, 0, 1.0))}};
  return script;
}

TEST(ScriptedDevice, RestsAtItsGraspBeforeTheStart) {
  const Pose X_WB0{RotationBy(Vec3(0.3, 0, 0)), Vec3(1, 2, 3)};
  ScriptedDevice device(Lift(), X_WB0);
  for (int frame = 0; frame < 500; ++frame) device.Render({});
  EXPECT_NEAR((device.Read().X_WA.p - X_WB0 * Vec3(0.05, 0, 0)).norm(), 0.0, 1e-12);
  EXPECT_EQ(device.time(), 0.0);
}

TEST(ScriptedDevice, ArrivesWhereItsScriptEnds) {
  ScriptedDevice device(Lift(), Pose{});
  device.Start();
  for (int frame = 0; frame < 4000; ++frame) device.Render({});
  const Quat turn = RotationBy(Vec3(0, 0, 1.0));
  EXPECT_NEAR((device.Read().X_WA.p - (Vec3(0, 0, 0.1) + turn * Vec3(0.05, 0, 0))).norm(), 0.0,
              1e-4);
  EXPECT_NEAR(device.Read().X_WA.q.angularDistance(turn), 0.0, 1e-3);
}

TEST(ScriptedDevice, ItsClockCountsFrames) {
  ScriptedDevice device(Lift(), Pose{});
  device.Start();
  for (int frame = 0; frame < 250; ++frame) device.Render({});
  EXPECT_NEAR(device.time(), 0.25, 1e-12);
}

TEST(ScriptedDevice, StaysInPlaceWithoutWaypoints) {
  ScriptedDevice device(HandScript{}, {Quat::Identity(), Vec3(1, 2, 3)});
  device.Start();
  for (int frame = 0; frame < 100; ++frame) device.Render({});
  EXPECT_NEAR((device.Read().X_WA.p - Vec3(1, 2, 3)).norm(), 0.0, 1e-12);
}

// 5 N for 50 ms on 0.5 kg that nothing holds: 0.5 m/s, whenever the push comes.
TEST(ScriptedDevice, KnockGivesItsMomentum) {
  for (const double at : {0.2, 1.0, 20.37}) {
    HandScript script;
    script.impedance = {.mass = 0.5, .damping = 0, .stiffness = 0};
    script.pushes = {{at, 0.05, {Vec3::Zero(), Vec3(5, 0, 0)}}};
    ScriptedDevice device(script, Pose{});
    for (int frame = 0; frame < 100; ++frame) device.Render({});
    device.Start();
    while (device.time() < at + 0.1) device.Render({});
    EXPECT_NEAR(device.Read().V_WA.v.x(), 0.5, 1e-9) << at;
  }
}

// A steady push of F moves a hand of stiffness k by F/k.
TEST(ScriptedDevice, YieldsByForceOverStiffness) {
  ScriptedDevice device(Lift(), Pose{});
  for (int frame = 0; frame < 5000; ++frame) device.Render({Vec3(0, 0.3, 0), Vec3(3.0, 0, 0)});
  EXPECT_NEAR((device.Read().X_WA.p - Vec3(0.05 + 3.0 / 300.0, 0, 0)).norm(), 0.0, 1e-5);
  EXPECT_NEAR(RotationVector(device.Read().X_WA.q).y(), 0.3 / 3.0, 1e-3);
}

}  // namespace
}  // namespace tandem
