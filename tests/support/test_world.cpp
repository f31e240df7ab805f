#include "tests/support/test_world.h"

#include "engine/base/check.h"
#include "engine/world/world_of_meshes.h"

namespace tandem::testing {

std::shared_ptr<const WorldModel> MakeWorldModel(const std::vector<TestBody>& bodies,
                                                 double voxel_size, ContactModel contact) {
  std::vector<MeshBody> parts;
  for (const TestBody& body : bodies) parts.push_back({body.mesh_W, body.fixed, body.mass});
  auto made = WorldOfMeshes(parts, voxel_size, contact);
  TANDEM_CHECK(made.has_value());
  return *made;
}

StepInputs FreeInputs(const WorldModel& model) {
  StepInputs inputs = ParkedInputs(model);
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    inputs.instances[b].drive = BodyDrive::kSimulated;
  }
  return inputs;
}

StepInputs::Hand HandTo(const WorldModel& model, int body, const Pose& X_WG) {
  return {.body = body,
          .X_BD = {},
          .goal = {X_WG, {}},
          .gains = DefaultHandGains(model.bodies[static_cast<std::size_t>(body)].inertia)};
}

void RunFrames(World& world, const StepInputs& inputs, int frames) {
  for (int frame = 0; frame < frames; ++frame) world.Step(inputs);
}

std::vector<Vec3> CornersOf(const WorldModel& model, std::size_t body) {
  const Pose X_BW = model.bodies[body].X_WB0.Inverse();
  std::vector<Vec3> corners = MeshOfBody(model, body).vertices;
  for (Vec3& corner : corners) corner = X_BW * corner;
  return corners;
}

double KineticEnergy(const WorldModel& model, std::size_t body, const RigidState& state) {
  const Inertia& inertia = model.bodies[body].inertia;
  const Vec3 w_B = state.X_WB.q.conjugate() * state.V_WB.w;
  return 0.5 * inertia.mass * state.V_WB.v.squaredNorm() + 0.5 * w_B.dot(inertia.I_B * w_B);
}

}  // namespace tandem::testing
