#include <gtest/gtest.h>

#include "app/judgement/penetration_oracle.h"
#include "tests/support/simulated_demo.h"

namespace tandem {
namespace {

/// Two peers in ball and socket, each with an object of its own, frame by frame.
struct BallAndSocket {
  BallAndSocket() {
    const Result<Scene> scene = testing::GeneratedScene("ball_and_socket");
    EXPECT_TRUE(scene) << (scene ? "" : scene.error().what);
    const auto loaded = LoadWorld(*scene);
    EXPECT_TRUE(loaded) << (loaded ? "" : loaded.error().what);
    model = *loaded;
    for (std::size_t h = 0; h < 2; ++h) {
      const Result<HandScript> script = LoadHandScript(scene->hands[h].file);
      EXPECT_TRUE(script) << (script ? "" : script.error().what);
      NodeOptions options;
      options.peer.wait_for = 1;
      options.conditions.delay_ms = 20;
      seconds = std::max(seconds, script->duration());
      session.Add(
          testing::MakeNode(model, 1 + h, scene->BodyNamed(scene->hands[h].body), *script, options),
          1 + h);
    }
  }

  std::shared_ptr<const WorldModel> model;
  SimulatedSession session;
  double seconds = 0;
};

TEST(OwnObjects, BothPeersFeelContactWithoutPenetration) {
  BallAndSocket scene;
  ASSERT_EQ(scene.model->bodies.size(), 2U);
  const double s = scene.model->scene.voxel_size;
  const auto frames = static_cast<int>(1000 * scene.seconds) + 1500;
  std::array<int, 2> contact_frames{};
  std::array<double, 2> peak_force{};
  double largest_mirror_travel = 0;
  std::vector<std::vector<Pose>> relative(2);
  for (int frame = 0; frame < frames; ++frame) {
    std::array<Vec3, 2> mirrors;
    for (std::size_t p = 0; p < 2; ++p) {
      mirrors[p] = scene.session.node(p).world().state(1 - p).X_WB.p;
    }
    scene.session.Step();
    for (std::size_t p = 0; p < 2; ++p) {
      const World& world = scene.session.node(p).world();
      const StepReport& report = scene.session.node(p).peer().report();
      contact_frames[p] += report.pushing_points > 0 ? 1 : 0;
      peak_force[p] = std::max(peak_force[p], report.hand_B_W.f.norm());
      largest_mirror_travel =
          std::max(largest_mirror_travel, (world.state(1 - p).X_WB.p - mirrors[p]).norm());
      if (frame % 10 == 0) {
        relative[p].push_back(world.state(1).X_WB.Inverse() * world.state(0).X_WB);
      }
    }
  }
  for (std::size_t p = 0; p < 2; ++p) {
    EXPECT_GT(contact_frames[p], frames / 10) << "peer " << p;
    EXPECT_GT(peak_force[p], 0.3) << "peer " << p;
  }
  // half of the pair's half voxel
  EXPECT_LE(largest_mirror_travel, 0.25 * s * 1.000001);

  // exact surfaces, each peer's own object against its mirror of the other's; the points are
  // shifted inward by half a voxel, which lets them as much deeper
  const auto mesh_B = [&](std::size_t body) {
    const std::uint32_t object = scene.model->object[body];
    return Transformed(scene.model->meshes_W[object], scene.model->bodies[body].X_WB0.Inverse());
  };
  const PenetrationOracle oracle(mesh_B(1), mesh_B(0), s);
  const PenetrationReport report = oracle.Check(relative, 2, [] {
    return false;
  });
  EXPECT_EQ(report.poses_checked, report.poses_given);
  EXPECT_LE(report.max_penetration_voxels, 1.0);
}

}  // namespace
}  // namespace tandem
