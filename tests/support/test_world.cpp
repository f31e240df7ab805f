#include "tests/support/test_world.h"

#include "engine/base/check.h"
#include "engine/geometry/mass_properties.h"

namespace tandem::testing {

std::shared_ptr<const WorldModel> MakeWorldModel(const std::vector<TestBody>& bodies,
                                                 double voxel_size, ContactModel contact) {
  auto world = std::make_shared<WorldModel>();
  world->scene.name = "made in code";
  world->scene.file = "nowhere.json";
  world->scene.voxel_size = voxel_size;
  world->scene.contact = contact;
  world->scene.force_layer = DefaultForceLayer(contact);
  TriangleMesh fixture;
  for (const TestBody& body : bodies) {
    world->scene.bodies.emplace_back().fixed = body.fixed;
    world->meshes_W.push_back(body.mesh_W);
    if (body.fixed) {
      world->body_index.push_back(-1);
      Append(fixture, body.mesh_W);
      continue;
    }
    const MassProperties mass = ComputeMassProperties(body.mesh_W);
    BodyModel model;
    model.X_WB0.p = mass.p_MBo;
    model.inertia = {body.mass, body.mass * mass.unit_inertia};
    Result<Pointshell> points = MakePoints(world->scene, body.mesh_W, model.X_WB0, 0);
    TANDEM_CHECK(points.has_value());
    model.points = std::move(*points);
    TANDEM_CHECK(!MakeMap(world->scene, body.mesh_W, model.voxmap));
    if (contact == ContactModel::kRefined) {
      Result<BodySurface> surface = MakeSurface(world->scene, body.mesh_W, model.X_WB0);
      TANDEM_CHECK(surface.has_value());
      model.surface = std::move(*surface);
    }
    model.X_BV = model.X_WB0.Inverse() * Pose{Quat::Identity(), model.voxmap.p_WVo()};
    world->object.push_back(static_cast<std::uint32_t>(world->body_index.size()));
    world->body_index.push_back(static_cast<int>(world->bodies.size()));
    world->bodies.push_back(std::move(model));
  }
  if (!fixture.triangles.empty()) {
    TANDEM_CHECK(!MakeMap(world->scene, fixture, world->fixture));
    if (contact == ContactModel::kRefined) {
      Result<BodySurface> surface = MakeSurface(world->scene, fixture, Pose{});
      TANDEM_CHECK(surface.has_value());
      world->fixture_surface = std::move(*surface);
      world->fixture_surface.radius = 0;
    }
    world->has_fixture = true;
  }
  return world;
}

StepInputs FreeInputs(const WorldModel& model) {
  StepInputs inputs;
  inputs.bodies.resize(model.bodies.size());
  for (StepInputs::BodyInput& body : inputs.bodies) body.drive = BodyDrive::kSimulated;
  return inputs;
}

StepInputs::Hand HandTo(const WorldModel& model, int body, const Pose& X_WG) {
  return {.body = body,
          .X_BD = {},
          .goal = {X_WG, {}},
          .gains = DefaultHandGains(model.bodies[static_cast<std::size_t>(body)].inertia)};
}

double KineticEnergy(const WorldModel& model, std::size_t body, const RigidState& state) {
  const Inertia& inertia = model.bodies[body].inertia;
  const Vec3 w_B = state.X_WB.q.conjugate() * state.V_WB.w;
  return 0.5 * inertia.mass * state.V_WB.v.squaredNorm() + 0.5 * w_B.dot(inertia.I_B * w_B);
}

}  // namespace tandem::testing
