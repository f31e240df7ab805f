#include "engine/world/world_of_meshes.h"

#include <optional>
#include <utility>

#include "engine/geometry/exact/union_mass.h"

namespace tandem {

namespace {

std::optional<Error> MakeBody(const Scene& scene, const MeshBody& body, BodyModel& model) {
  const MassProperties mass = ComputeUnionMass(body.mesh_W);
  model.X_WB0.p = mass.p_MBo;
  model.inertia = {body.mass, body.mass * mass.unit_inertia};
  return MakeShape(scene, scene.bodies.back(), body.mesh_W, true, model);
}

}  // namespace

Result<std::shared_ptr<const WorldModel>> WorldOfMeshes(const std::vector<MeshBody>& bodies,
                                                        double voxel_size, ContactModel contact,
                                                        double clearance_range_voxels) {
  auto world = std::make_shared<WorldModel>();
  world->scene.name = "made in code";
  world->scene.file = "nowhere.json";
  world->scene.voxel_size = voxel_size;
  world->scene.contact = contact;
  world->scene.clearance_range_voxels = clearance_range_voxels;
  world->scene.force_layer = DefaultForceLayer(contact);
  TriangleMesh fixture;
  for (const MeshBody& body : bodies) {
    world->scene.bodies.emplace_back().fixed = body.fixed;
    world->meshes_W.push_back(body.mesh_W);
    if (body.fixed) {
      world->body_index.push_back(-1);
      Append(fixture, body.mesh_W);
      continue;
    }
    BodyModel model;
    if (std::optional<Error> fault = MakeBody(world->scene, body, model)) return *fault;
    world->object.push_back(static_cast<std::uint32_t>(world->body_index.size()));
    world->body_index.push_back(static_cast<int>(world->bodies.size()));
    world->bodies.push_back(std::move(model));
  }
  if (!fixture.triangles.empty()) {
    if (std::optional<Error> fault = MakeFixture(fixture, *world)) return *fault;
  }
  return std::shared_ptr<const WorldModel>(std::move(world));
}

}  // namespace tandem
