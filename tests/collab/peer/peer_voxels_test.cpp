// Tests a peer whose voxels are in memory in part, and come late or never.
#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "collab/simulated/network/simulated_session.h"
#include "tests/support/paged_model.h"

namespace tandem {
namespace {

/// A device that drags what it holds along x and presses it down. It keeps the force that it is
/// given.
class DraggingDevice : public Device {
 public:
  explicit DraggingDevice(const Pose& home) : goal_(home) { goal_.p.z() -= 0.008; }
  void Start() noexcept override {}
  Anchor Read() noexcept override {
    if (moves) goal_.p.x() += 0.0004;
    return {.X_WA = goal_, .V_WA = {}};
  }
  void Render(const Wrench& F_D_W) noexcept override { force = F_D_W.f.norm(); }
  DeviceCapabilities capabilities() const noexcept override { return {}; }

  bool moves = true;
  double force = 0;  // N; force of the last frame

 private:
  Pose goal_;
};

struct Dragging {
  Dragging() {
    const auto whole = testing::Washboard();
    pages = std::make_shared<testing::DelayedPages>(whole->fixture);
    auto made = std::make_unique<DraggingDevice>(whole->bodies[0].X_WB0);
    device = made.get();
    NodeOptions options;
    options.peer.id = 1;
    options.peer.held_object = whole->object[0];
    auto owned = std::make_unique<PeerNode>(testing::PagedModel(*whole, pages), std::move(made), 42,
                                            options);
    node = owned.get();
    session.Add(std::move(owned), 1);
  }
  /// Steps with all pages there that were asked for.
  void Step(int count) {
    for (int k = 0; k < count; ++k) {
      node->world().WaitForVoxels();
      session.Step();
    }
  }
  /// Steps until the world waits for voxels, or does not any more.
  bool StepUntilWaiting(bool waiting, int most) {
    for (int k = 0; k < most; ++k) {
      session.Step();
      if ((node->peer().report().waited > 0) == waiting) return true;
      if (!waiting) std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
    return false;
  }

  std::shared_ptr<testing::DelayedPages> pages;
  SimulatedSession session;
  DraggingDevice* device = nullptr;
  PeerNode* node = nullptr;
};

TEST(PeerVoxels, ForceIsZeroWhileWaitingThenRamps) {
  Dragging dragging;
  dragging.Step(400);
  EXPECT_GT(dragging.device->force, 0.5) << "it presses on nothing";
  dragging.pages->Close();
  ASSERT_TRUE(dragging.StepUntilWaiting(true, 9000));
  dragging.device->moves = false;
  for (int k = 0; k < 20; ++k) dragging.session.Step();
  EXPECT_EQ(dragging.device->force, 0);
  EXPECT_NE(dragging.node->world().state(0).V_WB.v, Vec3::Zero());  // it goes on with that
  EXPECT_FALSE(dragging.node->peer().telemetry().voxels_missing());
  dragging.pages->Open();
  ASSERT_TRUE(dragging.StepUntilWaiting(false, 20000));
  // the pull comes back in a hundred frames
  const double first = dragging.device->force;
  dragging.Step(9);
  EXPECT_EQ(dragging.node->peer().guard().state(), SafetyState::kRamping);
  dragging.Step(90);
  const double whole = dragging.device->force;
  EXPECT_GT(whole, 1);
  EXPECT_LT(first, 0.1 * whole);
  EXPECT_EQ(dragging.node->peer().guard().state(), SafetyState::kOn);
  const VoxelWaits& waits = dragging.node->peer().telemetry().voxel_waits();
  EXPECT_EQ(waits.count, 1);
  EXPECT_EQ(waits.frames, waits.longest);
  EXPECT_GE(waits.frames, 21);
}

TEST(PeerVoxels, ReportsMissingVoxelsAfterTwoSeconds) {
  Dragging dragging;
  dragging.pages->Close();
  ASSERT_TRUE(dragging.StepUntilWaiting(true, 9000));
  for (int k = 2; k < kLongestVoxelWait; ++k) dragging.session.Step();
  EXPECT_FALSE(dragging.node->peer().telemetry().voxels_missing());
  dragging.session.Step();
  EXPECT_TRUE(dragging.node->peer().telemetry().voxels_missing());
  EXPECT_NE(dragging.node->world().MissingVoxelsReason().find("--voxel-memory"), std::string::npos);
}

}  // namespace
}  // namespace tandem
