#include "collab/mirror/remote_bodies.h"

#include <optional>

#include <gtest/gtest.h>

#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

/// The second instance of the first of two bodies, in a world where that one alone is shared.
constexpr InstanceIndex kSecondInstance = 2;

ObjectState StateOf(PeerId peer, std::uint32_t seq, double x, std::uint32_t flags) {
  ObjectState state;
  state.peer = peer;
  state.epoch = 1;
  state.seq = seq;
  state.flags = flags;
  state.X_WB.p.x() = x;
  return state;
}

/// Returns the change by which peer 7 has the first body in its hand.
MembershipChange Holder() {
  MembershipChange change;
  change.peer = 7;
  change.claim_count = 1;
  change.claims[0] = {.object = 0, .epoch = 1, .held = true};
  return change;
}

class LooseBody : public ::testing::Test {
 protected:
  LooseBody() {
    const TriangleMesh box = testing::Box(Vec3(0.02, 0.02, 0.02));
    const auto made = std::make_shared<WorldModel>(*testing::MakeWorldModel({{box}}, 0.001));
    made->scene.bodies[0].free = true;
    model_ = made;
    remote_.emplace(*model_);
    world_.emplace(model_);
    inputs_ = testing::FreeInputs(*model_);
  }
  const StepInputs::InstanceInput& Prepared() {
    remote_->Prepare(-1, inputs_);
    return inputs_.instances[0];
  }
  /// Runs a whole frame, and returns where the mirror is then.
  double Frame() {
    remote_->Prepare(-1, inputs_);
    remote_->ApplyCompliance(*world_, {}, inputs_);
    world_->Step(inputs_);
    return world_->state(0).X_WB.p.x();
  }

  std::shared_ptr<const WorldModel> model_;
  std::optional<RemoteBodies> remote_;
  std::optional<World> world_;
  StepInputs inputs_;
};

TEST_F(LooseBody, IsFollowedUntilItsPeerParksIt) {
  EXPECT_EQ(Prepared().drive, BodyDrive::kParked);
  remote_->OnState(StateOf(7, 2, 0.2, kStateLoose));
  EXPECT_EQ(Prepared().drive, BodyDrive::kMirrored);
  EXPECT_EQ(Prepared().mirror_WB.p.x(), 0.2);
  remote_->OnState(StateOf(7, 1, 0.1, kStateLoose));
  EXPECT_EQ(Prepared().mirror_WB.p.x(), 0.2) << "that one was older";
  remote_->OnState(StateOf(9, 1, 0.3, kStateLoose));
  EXPECT_EQ(Prepared().mirror_WB.p.x(), 0.3) << "another answers for it";
  remote_->OnState(StateOf(9, 2, 0.3, kStateParked));
  EXPECT_EQ(Prepared().drive, BodyDrive::kParked);
}

// The claim of a hand that lets go is heard later than the flight of what it threw is seen.
TEST_F(LooseBody, IsFollowedInSpiteOfAnOutdatedHolder) {
  remote_->OnMembership(Holder());
  remote_->OnState(StateOf(7, 1, 0.1, 0));
  EXPECT_EQ(Prepared().mirror_WB.p.x(), 0.1);
  remote_->OnState(StateOf(7, 2, 0.2, kStateLoose));
  EXPECT_EQ(Prepared().mirror_WB.p.x(), 0.2);
  remote_->OnState(StateOf(7, 3, 0.3, 0));
  EXPECT_EQ(Prepared().mirror_WB.p.x(), 0.3) << "it has it again";
}

TEST_F(LooseBody, StartsAtItsReceivedVelocityOnTakeover) {
  ObjectState state = StateOf(7, 1, 0.1, kStateLoose);
  state.V_WB.v.x() = 0.4;
  remote_->OnState(state);
  Prepared();
  remote_->TakeOver(0, inputs_);
  EXPECT_EQ(inputs_.instances[0].drive, BodyDrive::kSimulated);
  EXPECT_EQ(inputs_.instances[0].begin_V_WB.v.x(), 0.4);
  EXPECT_EQ(Prepared().drive, BodyDrive::kParked) << "what was told before is forgotten";
}

// The body goes 1 m/s at peer 7. Peer 9 goes on with it 20 mm from there and 40 ms later.
TEST_F(LooseBody, TakeoverNeitherStopsNorMovesIt) {
  double last = 0;
  const auto run = [&](PeerId peer, double from, int frames) {
    for (int i = 1; i <= frames; ++i) {
      if (peer != 0) {
        ObjectState state =
            StateOf(peer, static_cast<std::uint32_t>(i), from + 1e-3 * i, kStateLoose);
        state.V_WB.v.x() = 1;
        remote_->OnState(state);
      }
      const double now = Frame();
      EXPECT_GT(now - last, 0.2e-3) << peer << " " << i;
      EXPECT_LT(now - last, 2e-3) << peer << " " << i;
      last = now;
    }
  };
  run(7, 0, 100);
  EXPECT_NEAR(last, 0.1, 1e-6);
  run(0, 0, 40);
  run(9, 0.16, 400);
  EXPECT_NEAR(last, 0.56, 1e-4);
}

// Instances that are near make one mirror at their mean, and two when far. The distance to become
// one again is smaller.
TEST(RemoteBodies, InstancesSeparateAt40MillimetresAndMergeAt20) {
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
    EXPECT_EQ(inputs.instances[0].drive, BodyDrive::kMirrored);
    return inputs.instances[kSecondInstance].drive == BodyDrive::kMirrored;
  };
  EXPECT_FALSE(place({0, 0.03, 0.036}));
  EXPECT_NEAR(inputs.instances[0].mirror_WB.p.x(), 0.022, 1e-12);
  EXPECT_TRUE(place({0, 0.03, 0.041}));
  EXPECT_NEAR(inputs.instances[0].mirror_WB.p.x(), 0.0, 1e-12);
  EXPECT_NEAR(inputs.instances[kSecondInstance].mirror_WB.p.x(), 0.0355, 1e-12);
  EXPECT_TRUE(place({0, 0.03, 0.021}));
  EXPECT_FALSE(place({0, 0.01, 0.019}));
}

// 10 and 12 are on one side and tremble, 11 is alone on the other. Whichever of 10 and 12 is
// farther from 11, each instance of the picture stays on its side.
TEST(RemoteBodies, SeparatedInstancesStayOnTheirSidesUnderTremor) {
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
    ASSERT_EQ(inputs.instances[kSecondInstance].drive, BodyDrive::kMirrored);
    EXPECT_NEAR(inputs.instances[0].mirror_WB.p.x(), 0.0, 1e-12) << seq;
    EXPECT_NEAR(inputs.instances[kSecondInstance].mirror_WB.p.x(), 0.06, 1e-12) << seq;
  }
}

// Two peers hold the body 60 mm apart. A body that moves by forces here is in one place all the
// same.
TEST(RemoteBodies, TheSecondInstanceIsInactiveWhereTheBodyIsSimulated) {
  const TriangleMesh box = testing::Box(Vec3(0.02, 0.02, 0.02));
  WorldModel model = *testing::MakeWorldModel({{box}, {box}}, 0.001);
  model.scene.bodies[0].shared = true;
  RemoteBodies remote(model);
  StepInputs inputs = ParkedInputs(model);
  for (const PeerId peer : {PeerId{10}, PeerId{11}}) {
    MembershipChange change;
    change.peer = peer;
    change.claim_count = 1;
    change.claims[0] = {.object = 0, .epoch = 1, .held = true};
    remote.OnMembership(change);
    remote.OnState(StateOf(peer, 1, peer == 10 ? 0.0 : 0.06, 0));
  }
  remote.Prepare(1, inputs);
  EXPECT_EQ(inputs.instances[0].drive, BodyDrive::kMirrored);
  EXPECT_EQ(inputs.instances[1].drive, BodyDrive::kSimulated);
  EXPECT_EQ(inputs.instances[kSecondInstance].drive, BodyDrive::kMirrored);
  remote.TakeOver(0, inputs);
  EXPECT_EQ(inputs.instances[0].drive, BodyDrive::kSimulated);
  EXPECT_EQ(inputs.instances[kSecondInstance].drive, BodyDrive::kInactive);
  remote.Prepare(-1, inputs);
  EXPECT_EQ(inputs.instances[kSecondInstance].drive, BodyDrive::kMirrored);
  remote.Prepare(0, inputs);
  EXPECT_EQ(inputs.instances[0].drive, BodyDrive::kSimulated);
  EXPECT_EQ(inputs.instances[kSecondInstance].drive, BodyDrive::kInactive);
}

// A dead-reckoned mirror is half the loop's age ahead, by the velocity that was told, for 100 ms
// and 30 mm at the most. Mirrors of the other models are as received.
TEST(RemoteBodies, DeadReckonedMirrorsAreAtTheExtrapolatedPose) {
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
    const std::array<RoundTripTracker::Loop, 1> loops{{{.peer = 10, .age_s = loop_age_s}}};
    remote.Extrapolate(loops);
    remote.Prepare(1, inputs);
    return inputs.instances[0].mirror_WB.p.x();
  };
  EXPECT_NEAR(x_at(MirrorModel::kDeadReckoned, 0.2, 0.1), 0.51, 1e-12);
  EXPECT_NEAR(x_at(MirrorModel::kDeadReckoned, 0.2, 1.0), 0.52, 1e-12);   // 100 ms
  EXPECT_NEAR(x_at(MirrorModel::kDeadReckoned, -2.0, 0.1), 0.47, 1e-12);  // 30 mm
  EXPECT_EQ(x_at(MirrorModel::kHeld, 0.2, 0.1), 0.5);
  EXPECT_EQ(x_at(MirrorModel::kCompliantMirror, 0.2, 0.1), 0.5);
}

}  // namespace
}  // namespace tandem
