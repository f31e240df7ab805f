#include "collab/coupling/energy_gate.h"

#include <cmath>

#include <gtest/gtest.h>

namespace tandem {
namespace {

const Mat3 kPerMass = 1e-4 * Mat3::Identity();

Pose At(double x) {
  return {Quat::Identity(), Vec3(x, 0, 0)};
}

// 200 N/m from 0: 0.1 J is a stretch of sqrt(2 0.1 / 200) = 31.6 mm.
TEST(EnergyGate, MotionIsLimitedByCredit) {
  EnergyGate gate;
  const RigidState own;
  gate.Modulate(At(0), own, 200, kPerMass);
  EXPECT_NEAR(gate.Modulate(At(0.02), own, 200, kPerMass).p.x(), 0.02, 1e-12);
  EXPECT_FALSE(gate.clipped());
  EXPECT_NEAR(gate.tank(), 0.1 - 0.04, 1e-12);
  EXPECT_NEAR(gate.Modulate(At(0.1), own, 200, kPerMass).p.x(), std::sqrt(0.001), 1e-6);
  EXPECT_TRUE(gate.clipped());
  EXPECT_NEAR(gate.tank(), 0.0, 1e-6);
}

TEST(EnergyGate, CreditsEnergyReleasedOnTheWayBack) {
  EnergyGate gate;
  const RigidState own;
  gate.Modulate(At(0), own, 200, kPerMass);
  for (int i = 0; i < 100; ++i) {
    gate.Modulate(At(0.03), own, 200, kPerMass);
    gate.Modulate(At(0.0), own, 200, kPerMass);
  }
  EXPECT_NEAR(gate.tank(), 0.1, 1e-9);
  EXPECT_NEAR(gate.overflow(), 0.0, 1e-9);
}

// The overflow of one end pays for the other. A counter is no energy by itself.
TEST(EnergyGate, OverflowGoesToTheOtherEnd) {
  EnergyGate here;
  EnergyGate there;
  there.Credit(1.0);
  EXPECT_NEAR(there.overflow(), 0.9, 1e-12);
  here.Receive(there.overflow());  // from before they met
  EXPECT_NEAR(here.tank(), 0.1, 1e-12);
  there.Credit(0.2);
  for (int i = 0; i < 3; ++i) here.Receive(there.overflow());  // said three times, counted once
  EXPECT_NEAR(here.tank(), 0.1 + 0.18, 1e-12);
  EXPECT_EQ(here.overflow(), 0.0);
  here.Receive(1e9);
  EXPECT_NEAR(here.tank(), EnergyGate::kMost, 1e-12);
}

// A quarter of a turn at 10 N m/rad kg^-1 m^2: k/2 I/m theta^2.
TEST(EnergyGate, RotationConsumesCredit) {
  EnergyGate gate;
  const RigidState own;
  gate.Modulate(At(0), own, 200, kPerMass);
  const Pose turned{RotationBy(Vec3(0, 0, M_PI / 2)), Vec3::Zero()};
  gate.Modulate(turned, own, 200, kPerMass);
  EXPECT_NEAR(gate.tank(), 0.1 - 0.5 * 200 * 1e-4 * M_PI * M_PI / 4, 1e-9);
}

}  // namespace
}  // namespace tandem
