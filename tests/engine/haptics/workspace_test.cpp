#include "engine/haptics/workspace.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace tandem {
namespace {

/// A handle that is where the test says.
class PlacedDevice : public Device {
 public:
  void Start() noexcept override {}
  Anchor Read() noexcept override { return handle; }
  void Render(const Wrench& F_D_W) noexcept override { given = F_D_W; }
  DeviceCapabilities capabilities() const noexcept override {
    DeviceCapabilities can;
    can.stiffness = 600;
    can.workspace.Add(Vec3(-0.1, -0.1, -0.1));
    can.workspace.Add(Vec3(0.1, 0.1, 0.1));
    return can;
  }
  bool clutch_button() const noexcept override { return pressed; }
  Anchor handle;
  Wrench given;
  bool pressed = false;
};

void Order(Workspace& workspace, const WorkspaceOrder& order) {
  workspace.orders().back() = order;
  workspace.orders().Publish();
}

TEST(Workspace, IsTheIdentityByDefault) {
  PlacedDevice device;
  Workspace workspace(device);
  workspace.Start();
  device.handle = {{RotationBy(Vec3(0.1, 0.2, 0.3)), Vec3(1, 2, 3)},
                   {Vec3(1, 0, 0), Vec3(0, 1, 0)}};
  workspace.Read();
  device.handle.X_WA.p += Vec3(0.01, 0, 0);
  const Anchor mapped = workspace.Read();
  EXPECT_NEAR((mapped.X_WA.p - device.handle.X_WA.p).norm(), 0, 1e-15);
  EXPECT_NEAR(mapped.X_WA.q.angularDistance(device.handle.X_WA.q), 0, 1e-7);
  EXPECT_EQ(mapped.V_WA.v, Vec3(0, 1, 0));
}

// While a scene loads or a partner is waited for, the handle may be anywhere when the hand begins.
TEST(Workspace, HandleMovesAloneBeforeTheHandStarts) {
  PlacedDevice device;
  Workspace workspace(device);
  workspace.Read();
  device.handle = {{RotationBy(Vec3(0, 0, 0.5)), Vec3(0.1, 0, 0)}, {Vec3(0, 0, 1), Vec3(1, 0, 0)}};
  const Anchor waiting = workspace.Read();
  EXPECT_EQ(waiting.X_WA.p, Vec3(Vec3::Zero()));
  EXPECT_EQ(waiting.V_WA.v, Vec3(Vec3::Zero()));
  workspace.Render({Vec3::Zero(), Vec3(1, 0, 0)});
  EXPECT_EQ(device.given.f, Vec3(Vec3::Zero()));
  workspace.Start();
  EXPECT_NEAR(workspace.Read().X_WA.p.norm(), 0, 1e-15);
  device.handle.X_WA.p += Vec3(0, 0.02, 0);
  const Anchor led = workspace.Read();
  EXPECT_NEAR((led.X_WA.p - Vec3(0, 0.02, 0)).norm(), 0, 1e-15);
  EXPECT_NEAR(led.X_WA.q.angularDistance(Quat::Identity()), 0, 1e-7);
}

TEST(Workspace, DeviceButtonActsAsAClutch) {
  PlacedDevice device;
  Workspace workspace(device);
  workspace.Start();
  workspace.Read();
  device.pressed = true;
  workspace.Read();
  device.handle.X_WA.p = Vec3(0.05, 0, 0);
  EXPECT_EQ(workspace.Read().X_WA.p, Vec3(Vec3::Zero()));
  device.pressed = false;
  workspace.Read();
  device.handle.X_WA.p = Vec3(0.07, 0, 0);
  EXPECT_NEAR((workspace.Read().X_WA.p - Vec3(0.02, 0, 0)).norm(), 0, 1e-15);
}

// The clutch is let go of while the part is pressed into contact: the force takes a tenth of a
// second from nothing.
TEST(Workspace, ForceRampsAfterTheClutchIsReleased) {
  PlacedDevice device;
  Workspace workspace(device);
  workspace.Start();
  Wrench wanted;
  wanted.f.x() = 10;
  workspace.Read();
  workspace.Render(wanted);
  EXPECT_NEAR(device.given.f.x(), 10, 1e-12);  // nobody has held it yet
  device.pressed = true;
  workspace.Read();
  workspace.Render(wanted);
  EXPECT_TRUE(device.given.f.isZero());
  device.pressed = false;
  for (int i = 1; i <= 100; ++i) {
    workspace.Read();
    workspace.Render(wanted);
    EXPECT_NEAR(device.given.f.x(), 0.1 * i, 1e-9);
  }
  workspace.Read();
  workspace.Render(wanted);
  EXPECT_NEAR(device.given.f.x(), 10, 1e-9);
}

TEST(Workspace, GrabsAtTheGivenPointAndContinuesFromIt) {
  PlacedDevice device;
  Workspace workspace(device, {.scale = 10});
  workspace.Start();
  device.handle.X_WA.p = Vec3(0.03, 0, 0);
  workspace.Read();
  WorkspaceOrder order{.scale = 10};
  WorkspaceChange{.p_WD = Vec3(5, 6, 7)}.ApplyTo(order);
  Order(workspace, order);
  EXPECT_EQ(workspace.Read().X_WA.p, Vec3(5, 6, 7));
  device.handle.X_WA.p = Vec3(0.04, 0, 0);
  EXPECT_NEAR((workspace.Read().X_WA.p - Vec3(5.1, 6, 7)).norm(), 0, 1e-12);
  // with a part in it the hand stays where it is
  workspace.Holding(true);
  WorkspaceChange{.p_WD = Vec3(0, 0, 0)}.ApplyTo(order);
  Order(workspace, order);
  EXPECT_NEAR((workspace.Read().X_WA.p - Vec3(5.1, 6, 7)).norm(), 0, 1e-12);
}

TEST(Workspace, ScalesAndTurnsByTheView) {
  PlacedDevice device;
  WorkspaceOrder order;
  order.scale = 5;
  order.q_WV = RotationBy(Vec3(0, 0, M_PI / 2));  // the device's x is the scene's y
  Workspace workspace(device, order);
  workspace.Start();
  workspace.Read();
  device.handle.X_WA.p = Vec3(0.02, 0, 0);
  device.handle.X_WA.q = RotationBy(Vec3(0.3, 0, 0));
  device.handle.V_WA = {Vec3(1, 0, 0), Vec3(0.1, 0, 0)};
  const Anchor mapped = workspace.Read();
  EXPECT_NEAR((mapped.X_WA.p - Vec3(0, 0.1, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR(mapped.X_WA.q.angularDistance(RotationBy(Vec3(0, 0.3, 0))), 0, 1e-7);
  EXPECT_NEAR((mapped.V_WA.v - Vec3(0, 0.5, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR((mapped.V_WA.w - Vec3(0, 1, 0)).norm(), 0, 1e-12);
  workspace.Render({Vec3(0, 0.1, 0), Vec3(0, 3, 0)});
  EXPECT_NEAR((device.given.f - Vec3(3, 0, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR((device.given.tau - Vec3(0.1, 0, 0)).norm(), 0, 1e-12);
  // 120 N/m of the scene are felt as 600
  EXPECT_EQ(workspace.capabilities().stiffness, 120);
}

TEST(Workspace, ClutchMovesTheHandWithoutThePart) {
  PlacedDevice device;
  Workspace workspace(device, {.scale = 2});
  workspace.Start();
  workspace.Read();
  device.handle.X_WA.p = Vec3(0.1, 0, 0);
  EXPECT_NEAR(workspace.Read().X_WA.p.x(), 0.2, 1e-12);
  Order(workspace, {.scale = 2, .clutch = true});
  for (int i = 0; i <= 100; ++i) {
    device.handle.X_WA.p.x() = 0.1 - 0.002 * i;
    device.handle.V_WA.v.x() = -2;
    const Anchor mapped = workspace.Read();
    EXPECT_NEAR(mapped.X_WA.p.x(), 0.2, 1e-12);
    EXPECT_TRUE(mapped.V_WA.v.isZero());
    workspace.Render({Vec3::Zero(), Vec3(3, 0, 0)});
    EXPECT_TRUE(device.given.f.isZero());
  }
  Order(workspace, {.scale = 2});
  EXPECT_NEAR(workspace.Read().X_WA.p.x(), 0.2, 1e-12);
  device.handle.X_WA.p.x() += 0.05;
  EXPECT_NEAR(workspace.Read().X_WA.p.x(), 0.3, 1e-12);
}

// The mapped handle goes no farther in a frame than its hand, whatever is changed, and whenever.
TEST(Workspace, ChangesAreContinuous) {
  PlacedDevice device;
  Workspace workspace(device);
  workspace.Start();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> share(-1, 1);
  Pose last = workspace.Read().X_WA;
  WorkspaceOrder order;
  for (int i = 0; i < 20'000; ++i) {
    if (random() % 50 == 0) {
      workspace.Rescale(random() % 40 == 0 ? std::nan("") : std::pow(10, share(random)));
      order.q_WV = RotationBy(3 * Vec3(share(random), share(random), share(random)));
      order.clutch = random() % 3 == 0;
      order.recentre = random() % 2 == 0 ? 0.3 : 0;
      Order(workspace, order);
    }
    const Vec3 step = 2e-4 * Vec3(share(random), share(random), share(random));
    const Vec3 turn = 2e-3 * Vec3(share(random), share(random), share(random));
    device.handle.X_WA.p += step;
    device.handle.X_WA.q = RotationBy(turn) * device.handle.X_WA.q;
    const Pose mapped = workspace.Read().X_WA;
    EXPECT_LE((mapped.p - last.p).norm(), 10 * 1.3 * step.norm() + 1e-12) << i;
    EXPECT_LE(mapped.q.angularDistance(last.q), turn.norm() + 1e-7) << i;
    last = mapped;
  }
}

TEST(Workspace, RecentringReturnsTheHandToTheCentre) {
  PlacedDevice device;
  Workspace workspace(device, {.recentre = 0.2});
  workspace.Start();
  workspace.Read();
  // the user holds the mapped handle about 80 mm from where it began, and trembles 5 mm
  const double goal = 0.08;
  for (int i = 0; i < 60'000; ++i) {
    const double wanted = goal + 0.005 * std::sin(0.02 * i);
    const double off = wanted - workspace.Read().X_WA.p.x();
    device.handle.X_WA.p.x() += 0.05 * off;
  }
  EXPECT_NEAR(workspace.Read().X_WA.p.x(), goal, 0.01);
  EXPECT_LT(std::abs(device.handle.X_WA.p.x()), 0.02);
  // at rest nothing moves
  const Pose before = workspace.Read().X_WA;
  for (int i = 0; i < 1000; ++i) workspace.Read();
  EXPECT_EQ(workspace.Read().X_WA.p, before.p);
}

}  // namespace
}  // namespace tandem
