#include <gtest/gtest.h>

#include "collab/simulated/network/simulated_session.h"
#include "engine/haptics/scripted_device.h"
#include "engine/scene/force_parameters.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

// Two equal bars, crossed, are pressed together by two equal hands whose users simulate by voxels
// of 1 mm and of 2 mm (paper §6.1). One of them pushes harder, by a known amount.

namespace tandem {
namespace {

constexpr double kMass = 0.1;      // kg, of a bar
constexpr double kThick = 0.02;    // m
constexpr double kBetween = 0.06;  // m; distance of their middles at first

/// Returns crossed bars. By voxels alone, which feel no edges that cross at right angles, it
/// returns balls.
std::shared_ptr<const WorldModel> Parts(double voxel_size, ContactModel contact) {
  const bool balls = contact == ContactModel::kPlain;
  const TriangleMesh ball = testing::Sphere(kThick / 2, 4);
  const TriangleMesh along_y = balls ? ball : testing::Box(Vec3(kThick, 0.06, kThick));
  const TriangleMesh along_z = balls ? ball : testing::Box(Vec3(kThick, kThick, 0.06));
  return testing::MakeWorldModel({{testing::At(along_y, Vec3(-kBetween / 2, 0, 0)), false, kMass},
                                  {testing::At(along_z, Vec3(kBetween / 2, 0, 0)), false, kMass}},
                                 voxel_size, contact);
}

/// Two peers, the first by voxels of `first`, the second by those of `second`, each with a bar in
/// its hand; the first hand goes towards the other by `way` in `seconds`.
class Pressing {
 public:
  Pressing(const ForceParameters& first, const ForceParameters& second, double way, double seconds,
           double delay_ms = 0) {
    const std::array<ForceParameters, 2> by{first, second};
    for (const PeerId id : {PeerId{1}, PeerId{2}}) {
      const auto model = Parts(by[id - 1].voxel_size, by[id - 1].contact);
      HandScript script;
      script.waypoints = {{0, Vec3::Zero(), Quat::Identity()},
                          {seconds, Vec3(id == 1 ? way : 0, 0, 0), Quat::Identity()}};
      NodeOptions options;
      options.peer.id = id;
      options.peer.held_object = static_cast<int>(id) - 1;
      options.peer.wait_for = 1;
      options.conditions.delay_ms = delay_ms;
      options.name = std::to_string(id);
      session_.Add(std::make_unique<PeerNode>(
                       model, std::make_unique<ScriptedDevice>(script, model->bodies[id - 1].X_WB0),
                       42, options),
                   id);
    }
  }

  void Step(int frames) {
    for (int i = 0; i < frames; ++i) session_.Step();
  }
  /// Returns the force with which the bar of a peer (0, 1) is pushed back in its own simulation, N.
  double Pushed(std::size_t peer) { return report(peer).contact_B_W.f.norm(); }
  /// Returns the force of the deepest contact in a peer's own simulation, N.
  double AtDeepest(std::size_t peer) {
    double most = 0;
    for (const Contact& contact : session_.node(peer).world().pair(0).contacts()) {
      most = std::max(most, contact.force / contact.share);
    }
    return most;
  }
  const StepReport& report(std::size_t peer) { return session_.node(peer).peer().report(); }
  /// Returns the distance between the faces of the two bars as their own users have them, m.
  double Gap() {
    return session_.node(1).peer().held_state()->X_WB.p.x() -
           session_.node(0).peer().held_state()->X_WB.p.x() - kThick;
  }
  SimulatedSession& session() { return session_; }

 private:
  SimulatedSession session_;
};

ForceParameters By(double voxel_size, ContactModel contact = ContactModel::kRefined) {
  Scene scene;
  scene.voxel_size = voxel_size;
  scene.contact = contact;
  scene.force_layer = DefaultForceLayer(contact);
  return ParametersOf(scene);
}

// 40 mm until they touch, 20 mm more: two hands of 300 N/m with couplings of 800 N/m, 218 N/m each.
constexpr double kWay = 0.06;
constexpr double kSide = 1.0 / (1.0 / 300.0 + 1.0 / 800.0);

TEST(VoxelSizes, EqualSizesPushAlike) {
  Pressing pressing(By(0.001), By(0.001), kWay, 1.5);
  pressing.Step(5000);
  // two firm contacts share what both hands press by the way in which they met
  const double both = (0.02 + GapAtFirstForce(By(0.001))) * kSide;
  EXPECT_NEAR(pressing.Pushed(0) + pressing.Pushed(1), both, 0.05);
  EXPECT_NEAR(pressing.Pushed(0), both / 2, 0.25 * both);
}

// The warning's figures: the pushed one stands off at the gap at which its contact begins, has all
// of the force, twice that of equals, and the other nothing.
TEST(VoxelSizes, SmallerVoxelsPushHarderInRefinedContact) {
  const auto push = ComparePush(By(0.001), By(0.002), kMass);
  ASSERT_TRUE(push && push->first_harder);
  Pressing pressing(By(0.001), By(0.002), kWay, 1.5);
  pressing.Step(5000);
  EXPECT_EQ(pressing.Pushed(0), 0.0);
  EXPECT_NEAR(pressing.Pushed(1), (0.02 + GapAtFirstForce(By(0.002))) * kSide, 0.05);
  EXPECT_NEAR(pressing.Gap(), GapAtFirstForce(By(0.002)), 0.1e-3);

  Pressing swapped(By(0.002), By(0.001), kWay, 1.5);
  swapped.Step(5000);
  EXPECT_NEAR(swapped.Pushed(0), (0.02 + GapAtFirstForce(By(0.002))) * kSide, 0.05);
  EXPECT_EQ(swapped.Pushed(1), 0.0);
}

// Pressed harder and harder: the other feels something when the pushed one has the warning's
// newtons at each of its contacts. Before that it touches for a frame now and then, which takes
// what speed the two have and no more; so ten frames in a row count.
TEST(VoxelSizes, WarningStatesTheForceAtTheOthersOnset) {
  const auto push = ComparePush(By(0.001), By(0.002), kMass);
  ASSERT_TRUE(push);
  Pressing pressing(By(0.001), By(0.002), 2.5, 125);
  double felt_from = 0;
  int touching = 0;  // frames in a row
  for (int frame = 0; frame < 125000 && felt_from == 0; ++frame) {
    pressing.Step(1);
    touching = pressing.Pushed(0) > 0.05 ? touching + 1 : 0;
    if (touching == 10) felt_from = pressing.AtDeepest(1);
  }
  EXPECT_NEAR(felt_from, push->alone_force, 0.2 * push->alone_force);
}

// By voxels alone contact begins at the force layer, of faces along the axes within half a voxel.
TEST(VoxelSizes, SmallerVoxelsPushHarderInPlainContact) {
  const ForceParameters fine = By(0.001, ContactModel::kPlain);
  const ForceParameters coarse = By(0.002, ContactModel::kPlain);
  const auto push = ComparePush(fine, coarse, kMass);
  ASSERT_TRUE(push && push->first_harder);
  Pressing pressing(fine, coarse, kWay, 1.5);
  pressing.Step(5000);
  EXPECT_EQ(pressing.Pushed(0), 0.0);
  EXPECT_NEAR(pressing.Pushed(1), (0.02 + GapAtFirstForce(coarse)) * kSide, 0.5);
  EXPECT_NEAR(pressing.Gap(), GapAtFirstForce(coarse), 0.5 * coarse.voxel_size + 0.1e-3);
}

// Over a delay the mirrors give way, by B/te: both feel the other, and what is left between them is
// that stiffness times the head start.
TEST(VoxelSizes, DelayedContactDiffersOnlyByItsOnset) {
  const auto push = ComparePush(By(0.001), By(0.002), kMass);
  ASSERT_TRUE(push);
  for (const double delay_ms : {20.0, 100.0}) {
    Pressing pressing(By(0.001), By(0.002), kWay, 1.5, delay_ms);
    pressing.Step(8000);
    const double difference = pressing.Pushed(1) - pressing.Pushed(0);
    RecordProperty("difference_N_" + std::to_string(static_cast<int>(delay_ms)) + "_ms",
                   std::to_string(difference));
    EXPECT_GT(difference, 0.0) << delay_ms;
    EXPECT_LT(difference, 10.0 / (1e-3 * delay_ms) * push->head_start) << delay_ms;
  }
}

}  // namespace
}  // namespace tandem
