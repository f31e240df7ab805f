#include "collab/simulated/network/light_scene.h"

#include "engine/base/check.h"
#include "engine/geometry/mesh/mass_properties.h"

namespace tandem {

namespace {

constexpr double kVoxel = 0.002;  // m

TriangleMesh BoxAt(const Vec3& centre, const Vec3& size) {
  TriangleMesh mesh;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 unit(corner & 1, corner >> 1 & 1, corner >> 2);
    mesh.vertices.push_back(centre + size.cwiseProduct(unit - Vec3::Constant(0.5)));
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

void AddMoving(const std::string& name, const Vec3& centre, bool shared, WorldModel& world) {
  const TriangleMesh mesh = BoxAt(centre, Vec3::Constant(kLightSceneBox));
  SceneBody& part = world.scene.bodies.emplace_back();
  part.name = name;
  part.shared = shared;
  part.mass = 0.3;
  const MassProperties mass = ComputeMassProperties(mesh);
  BodyModel body;
  body.name = name;
  body.X_WB0.p = mass.p_MBo;
  body.inertia = {part.mass, part.mass * mass.unit_inertia};
  TANDEM_CHECK(!MakeShape(world.scene, part, mesh, true, body));
  world.object.push_back(static_cast<std::uint32_t>(world.body_index.size()));
  world.body_index.push_back(static_cast<int>(world.bodies.size()));
  world.bodies.push_back(std::move(body));
  world.meshes_W.push_back(mesh);
}

}  // namespace

SolidBox LightScenePlate() {
  return {{Quat::Identity(), Vec3(0, 0, -0.045)}, Vec3(0.1, 0.1, 0.01)};
}

std::shared_ptr<const WorldModel> MakeLightScene() {
  auto world = std::make_shared<WorldModel>();
  world->scene.name = "light";
  world->scene.file = "light.json";
  world->scene.voxel_size = kVoxel;
  const TriangleMesh plate = BoxAt(LightScenePlate().X_WB.p, 2.0 * LightScenePlate().half);
  world->scene.bodies.emplace_back().fixed = true;
  world->scene.bodies.back().name = "plate";
  world->body_index.push_back(-1);
  world->meshes_W.push_back(plate);
  TANDEM_CHECK(!MakeFixture(plate, *world));
  AddMoving("shared", Vec3::Zero(), true, *world);
  AddMoving("left", Vec3(-0.07, 0, 0), false, *world);
  AddMoving("right", Vec3(0.07, 0, 0), false, *world);
  return world;
}

}  // namespace tandem
