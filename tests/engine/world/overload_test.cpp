#include <gtest/gtest.h>

#include "engine/contact/schedule/max_travel.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

using testing::At;
using testing::Box;
using testing::FreeInputs;
using testing::HandTo;
using testing::kVoxel;
using testing::MakeWorldModel;
using testing::RandomDirection;
using testing::RandomRotation;
using testing::RunFrames;
using testing::Sphere;
using testing::Uniform;

// with no test to spare a body moves by the floor alone; a pair of moving bodies shares it
constexpr int kFramesForFiftyMillimetres = static_cast<int>(0.05 / (0.5 * kTravelFloor * kVoxel));

/// Presses for a second with room to spare, then squeezes the capacity, to nothing or by what a
/// query costs, and pulls to `out`. Returns how far from there the body is at the end, m.
double PulledOut(const std::shared_ptr<const WorldModel>& model, int body, const Pose& pressed,
                 const Pose& out, double capacity = 0, double query_price = 0) {
  kHapticThread.Enter();
  World world(model);
  StepInputs inputs = FreeInputs(*model);
  inputs.hand = HandTo(*model, body, pressed);
  int contacts = 0;
  for (int frame = 0; frame < 1000; ++frame) contacts = world.Step(inputs).contact_points;
  EXPECT_GT(contacts, 0);
  inputs.capacity = capacity;
  inputs.query_price = query_price;
  inputs.hand = HandTo(*model, body, out);
  EXPECT_NE(world.Step(inputs).flags & StepReport::kOverCapacity, 0U);
  RunFrames(world, inputs, 2 * kFramesForFiftyMillimetres);
  return (world.state(static_cast<std::size_t>(body)).X_WB.p - out.p).norm();
}

class Overload : public ::testing::TestWithParam<ContactModel> {};

// A bar is pressed askew into the bottom of a blind slot 1.5 mm wider than itself: faces, edges
// and corners touch on several sides at once.
TEST_P(Overload, JammedBarComesOut) {
  std::mt19937_64 random(41);
  std::vector<testing::TestBody> bodies{
      {At(Box(Vec3(0.05, 0.05, 0.006)), Vec3(0, 0, -0.033)), true}};
  for (const double side : {-1.0, 1.0}) {
    bodies.push_back({At(Box(Vec3(0.01, 0.05, 0.03)), Vec3(side * 0.0165, 0, -0.015)), true});
    bodies.push_back({At(Box(Vec3(0.023, 0.01, 0.03)), Vec3(0, side * 0.0165, -0.015)), true});
  }
  bodies.push_back({At(Box(Vec3(0.0215, 0.0215, 0.04)), Vec3(0, 0, 0.025))});
  const auto model = MakeWorldModel(bodies, kVoxel, GetParam());
  for (int trial = 0; trial < 3; ++trial) {
    const Pose pressed{RotationBy(0.3 * RandomDirection(random)),
                       Vec3(0.01 * Uniform(random, -1, 1), 0.01 * Uniform(random, -1, 1), -0.05)};
    EXPECT_LT(PulledOut(model, 0, pressed, {Quat::Identity(), Vec3(0, 0, 0.05)}), 1e-3);
  }
}

// Any body comes off a plate, however it is pressed onto it.
TEST_P(Overload, BodyPressedOntoAPlateSeparates) {
  std::mt19937_64 random(42);
  const TriangleMesh plate = At(Box(Vec3(0.08, 0.08, 0.01)), Vec3(0, 0, -0.005));
  for (int trial = 0; trial < 4; ++trial) {
    const TriangleMesh shape = trial % 2 == 0 ? Box(Vec3(0.03, 0.02, 0.01)) : Sphere(0.012, 3);
    const auto model =
        MakeWorldModel({{plate, true}, {At(shape, Vec3(0, 0, 0.025), RandomRotation(random))}},
                       kVoxel, GetParam());
    const Quat turn = RotationBy(0.5 * RandomDirection(random));
    EXPECT_LT(PulledOut(model, 0, {turn, Vec3(0, 0, -0.04)}, {turn, Vec3(0, 0, 0.045)}), 1e-3);
  }
}

TEST_P(Overload, BodySeparatesFromAMovingBody) {
  const auto model = MakeWorldModel({{Box(Vec3(0.04, 0.04, 0.01)), false, 1.0},
                                     {At(Box(Vec3(0.02, 0.02, 0.02)), Vec3(0, 0, 0.02))},
                                     {At(Box(Vec3(0.08, 0.08, 0.01)), Vec3(0, 0, -0.015)), true}},
                                    kVoxel, GetParam());
  EXPECT_LT(PulledOut(model, 1, Pose{}, {Quat::Identity(), Vec3(0, 0, 0.06)}), 1e-3);
}

// Queries of what is in contact take all that a frame has room for, but for the last fifth of what
// tests have.
TEST_P(Overload, BodySeparatesWhenQueriesFillItsFrames) {
  const double room = GetParam() == ContactModel::kPlain ? 1000 : 100;
  const auto model = MakeWorldModel({{At(Box(Vec3(0.08, 0.08, 0.01)), Vec3(0, 0, -0.005)), true},
                                     {At(Box(Vec3(0.03, 0.02, 0.01)), Vec3(0, 0, 0.025))}},
                                    kVoxel, GetParam());
  EXPECT_LT(PulledOut(model, 0, {Quat::Identity(), Vec3(0, 0, -0.04)},
                      {Quat::Identity(), Vec3(0, 0, 0.045)}, room, 1e9),
            1e-3);
}

INSTANTIATE_TEST_SUITE_P(Models, Overload,
                         ::testing::Values(ContactModel::kRefined, ContactModel::kPlain));

}  // namespace
}  // namespace tandem
