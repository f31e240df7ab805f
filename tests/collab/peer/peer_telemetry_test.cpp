#include "collab/peer/peer_telemetry.h"

#include <gtest/gtest.h>

#include "tests/support/solid_meshes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

using testing::kVoxel;

/// A peer's parts about one free box, as the telemetry reads them.
class PeerTelemetryTest : public ::testing::Test {
 protected:
  static constexpr PeerId kSelf = 5;

  PeerTelemetryTest()
      : model_(testing::MakeWorldModel(
            {{.mesh_W = testing::BoxBetween(Vec3::Zero(), Vec3::Constant(0.02))}}, kVoxel)),
        world_(model_),
        inputs_(testing::FreeInputs(*model_)),
        ownership_(kSelf, *model_, 0, false, &drops_),
        remote_(*model_),
        round_trips_(kSelf),
        separation_(kSelf, *model_) {}

  PeerTelemetry Make(std::size_t trace_frames = 0) const {
    return PeerTelemetry({.id = kSelf,
                          .world = world_,
                          .inputs = inputs_,
                          .report = report_,
                          .ownership = ownership_,
                          .remote = remote_,
                          .round_trips = round_trips_,
                          .separation = separation_,
                          .drops = drops_},
                         trace_frames);
  }

  std::shared_ptr<const WorldModel> model_;
  World world_;
  StepInputs inputs_;
  StepReport report_;
  DropTable drops_;
  Ownership ownership_;
  RemoteBodies remote_;
  RoundTripTracker round_trips_;
  InstanceSeparation separation_;
};

TEST_F(PeerTelemetryTest, CountsVoxelWaitsAndReportsTheirEnd) {
  PeerTelemetry telemetry = Make();
  for (const int waited : {0, 1, 2, 3, 0, 0, 1, 0}) {
    const bool ends = waited == 0 && report_.waited > 0;
    report_.waited = waited;
    EXPECT_EQ(telemetry.CountStep().voxels_came, ends);
  }
  EXPECT_EQ(telemetry.voxel_waits().count, 2);
  EXPECT_EQ(telemetry.voxel_waits().frames, 4);
  EXPECT_EQ(telemetry.voxel_waits().longest, 3);
  EXPECT_FALSE(telemetry.voxels_missing());
  report_.waited = kLongestVoxelWait;
  telemetry.CountStep();
  EXPECT_TRUE(telemetry.voxels_missing());
}

TEST_F(PeerTelemetryTest, ReportsContactOverflowOnce) {
  PeerTelemetry telemetry = Make();
  EXPECT_FALSE(telemetry.CountStep().first_crowded);
  report_.flags = StepReport::kContactsFull;
  EXPECT_TRUE(telemetry.CountStep().first_crowded);
  EXPECT_FALSE(telemetry.CountStep().first_crowded);
  EXPECT_EQ(telemetry.crowded_frames(), 2U);
}

TEST_F(PeerTelemetryTest, KeepsPeakDeviceForceAndForceStep) {
  PeerTelemetry telemetry = Make();
  telemetry.CountForce({Vec3(0, 0, 0.2), Vec3(3, 0, 0)});
  telemetry.CountForce({Vec3(0, 0, 0.1), Vec3(-2, 0, 0)});
  EXPECT_DOUBLE_EQ(telemetry.rendered().peak_force, 3);
  EXPECT_DOUBLE_EQ(telemetry.rendered().peak_moment, 0.2);
  EXPECT_DOUBLE_EQ(telemetry.rendered().peak_step, 5);
  EXPECT_DOUBLE_EQ(telemetry.rendered().F_D_W.f.x(), -2);
}

TEST_F(PeerTelemetryTest, TracesTheFirstFramesAndSumsAll) {
  PeerTelemetry telemetry = Make(2);
  for (int frame = 0; frame < 3; ++frame) {
    report_.contact_points = frame;
    report_.hand_B_W.f = Vec3(frame, 0, 0);
    telemetry.RecordHand(1'000'000 * frame, 0);
  }
  ASSERT_EQ(telemetry.trace().size(), 2U);
  EXPECT_EQ(telemetry.trace()[1].time_ns, 1'000'000);
  EXPECT_EQ(telemetry.trace()[1].contact_points, 1);
  EXPECT_EQ(telemetry.hand_figures().frames, 3);
  EXPECT_EQ(telemetry.hand_figures().frames_in_contact, 2);
  EXPECT_EQ(telemetry.hand_figures().contact_points, 3);
  EXPECT_DOUBLE_EQ(telemetry.hand_figures().peak_force, 2);
}

TEST_F(PeerTelemetryTest, ShowsViewersTheBodyInHandFirst) {
  const PeerTelemetry telemetry = Make();
  report_.contact_points = 4;
  report_.hand_B_W.f = Vec3(0, 1, 0);
  ViewFrame view;
  telemetry.FillView(7, 3, {.body = 0}, view);
  EXPECT_EQ(view.peer, kSelf);
  EXPECT_EQ(view.seq, 3U);
  ASSERT_EQ(view.count, 1U);
  EXPECT_EQ(view.bodies[0].object, model_->object[0]);
  EXPECT_EQ(view.bodies[0].flags, ViewBody::kHeld | ViewBody::kInContact);
  EXPECT_EQ(view.bodies[0].hand_force_W, Vec3(0, 1, 0));
}

}  // namespace
}  // namespace tandem
