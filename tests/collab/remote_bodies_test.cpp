#include "collab/remote_bodies.h"

#include <gtest/gtest.h>

#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

// A free body that nobody holds moves while we are alone, and stands while anybody else is there,
// holding something or not.
TEST(RemoteBodies, AFreeBodyIsSimulatedOnlyWhileNoOtherPeerIsThere) {
  const TriangleMesh box = testing::Box(Vec3(0.02, 0.02, 0.02));
  WorldModel model = *testing::MakeWorldModel({{box}, {box}, {box}}, 0.001);
  model.scene.bodies[1].free = true;
  using Kind = MembershipChange::Kind;
  RemoteBodies remote(model);
  StepInputs inputs = testing::FreeInputs(model);
  const auto drives = [&] {
    remote.Prepare(0, inputs);
    return std::vector<BodyDrive>{inputs.bodies[0].drive, inputs.bodies[1].drive,
                                  inputs.bodies[2].drive};
  };
  const std::vector<BodyDrive> alone{BodyDrive::kSimulated, BodyDrive::kSimulated,
                                     BodyDrive::kParked};
  const std::vector<BodyDrive> in_company{BodyDrive::kSimulated, BodyDrive::kParked,
                                          BodyDrive::kParked};
  EXPECT_EQ(drives(), alone);
  remote.OnMembership({.kind = Kind::kJoined, .peer = 7});
  remote.OnMembership({.kind = Kind::kClaims, .peer = 7});  // it took something else
  remote.OnMembership({.kind = Kind::kJoined, .peer = 9});
  EXPECT_EQ(drives(), in_company);
  remote.OnMembership({.kind = Kind::kLeft, .peer = 7});
  EXPECT_EQ(drives(), in_company);
  remote.OnMembership({.kind = Kind::kLost, .peer = 9});
  EXPECT_EQ(drives(), alone);
}

// Mean while near, two when far, and the distance to become one again is smaller.
TEST(RemoteBodies, InstancesPartAtFortyMillimetresAndMeetAtTwenty) {
  const TriangleMesh box = testing::Box(Vec3(0.02, 0.02, 0.02));
  WorldModel model = *testing::MakeWorldModel({{box}, {box}}, 0.001);
  model.scene.bodies[0].shared = true;
  RemoteBodies remote(model);
  StepInputs inputs = testing::FreeInputs(model);
  std::uint32_t seq = 0;
  const auto place = [&](std::vector<double> x) {
    ++seq;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const PeerId peer = 10 + i;
      MembershipChange change;
      change.peer = peer;
      change.claim_count = 1;
      change.claims[0] = {.object = 0, .epoch = 1, .held = true};
      if (seq == 1) remote.OnMembership(change);
      ObjectState state;
      state.peer = peer;
      state.epoch = 1;
      state.seq = seq;
      state.X_WB.p.x() = x[i];
      remote.OnState(state);
    }
    remote.Prepare(1, inputs);
    return inputs.bodies[0].parted;
  };
  EXPECT_FALSE(place({0, 0.03, 0.036}));
  EXPECT_NEAR(inputs.bodies[0].mirror_WB.p.x(), 0.022, 1e-12);
  EXPECT_TRUE(place({0, 0.03, 0.041}));
  EXPECT_NEAR(inputs.bodies[0].mirror_WB.p.x(), 0.0, 1e-12);
  EXPECT_NEAR(inputs.bodies[0].second_WB.p.x(), 0.0355, 1e-12);
  EXPECT_TRUE(place({0, 0.03, 0.021}));
  EXPECT_FALSE(place({0, 0.01, 0.019}));
}

// 10 and 12 are on one side and tremble, 11 is alone on the other: whoever of the two is farther
// from it, each instance of the picture stays on its side.
TEST(RemoteBodies, PartedInstancesStayOnTheirSidesWhileHandsTremble) {
  const TriangleMesh box = testing::Box(Vec3(0.02, 0.02, 0.02));
  WorldModel model = *testing::MakeWorldModel({{box}, {box}}, 0.001);
  model.scene.bodies[0].shared = true;
  RemoteBodies remote(model);
  StepInputs inputs = testing::FreeInputs(model);
  for (PeerId peer = 10; peer <= 12; ++peer) {
    MembershipChange change;
    change.peer = peer;
    change.claim_count = 1;
    change.claims[0] = {.object = 0, .epoch = 1, .held = true};
    remote.OnMembership(change);
  }
  for (std::uint32_t seq = 1; seq <= 20; ++seq) {
    const double tremble = seq % 2 == 0 ? 5e-4 : -5e-4;
    const std::array<double, 3> x{tremble, 0.06, -tremble};
    for (std::size_t i = 0; i < x.size(); ++i) {
      ObjectState state;
      state.peer = 10 + i;
      state.epoch = 1;
      state.seq = seq;
      state.X_WB.p.x() = x[i];
      remote.OnState(state);
    }
    remote.Prepare(1, inputs);
    ASSERT_TRUE(inputs.bodies[0].parted);
    EXPECT_NEAR(inputs.bodies[0].mirror_WB.p.x(), 0.0, 1e-12) << seq;
    EXPECT_NEAR(inputs.bodies[0].second_WB.p.x(), 0.06, 1e-12) << seq;
  }
}

// Half the loop's age ahead, by the velocity that was told, for 100 ms and 30 mm at the most; as
// received by the other models.
TEST(RemoteBodies, DeadReckonedMirrorsAreWhereTheyWouldBeByNow) {
  const TriangleMesh box = testing::Box(Vec3(0.02, 0.02, 0.02));
  const WorldModel model = *testing::MakeWorldModel({{box}, {box}}, 0.001);
  const auto x_at = [&](MirrorModel mirror, double speed, double loop_age_s) {
    RemoteBodies remote(model, mirror);
    StepInputs inputs = testing::FreeInputs(model);
    MembershipChange change;
    change.peer = 10;
    change.claim_count = 1;
    change.claims[0] = {.object = 0, .epoch = 1, .held = true};
    remote.OnMembership(change);
    ObjectState state;
    state.peer = 10;
    state.epoch = 1;
    state.seq = 1;
    state.X_WB.p.x() = 0.5;
    state.V_WB.v.x() = speed;
    remote.OnState(state);
    const std::array<Echoes::Loop, 1> loops{{{.peer = 10, .age_s = loop_age_s}}};
    remote.Reckon(loops);
    remote.Prepare(1, inputs);
    return inputs.bodies[0].mirror_WB.p.x();
  };
  EXPECT_NEAR(x_at(MirrorModel::kDeadReckoned, 0.2, 0.1), 0.51, 1e-12);
  EXPECT_NEAR(x_at(MirrorModel::kDeadReckoned, 0.2, 1.0), 0.52, 1e-12);   // 100 ms
  EXPECT_NEAR(x_at(MirrorModel::kDeadReckoned, -2.0, 0.1), 0.47, 1e-12);  // 30 mm
  EXPECT_EQ(x_at(MirrorModel::kHeld, 0.2, 0.1), 0.5);
  EXPECT_EQ(x_at(MirrorModel::kBlend, 0.2, 0.1), 0.5);
}

}  // namespace
}  // namespace tandem
