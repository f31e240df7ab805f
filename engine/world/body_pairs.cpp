#include "engine/world/body_pairs.h"

#include <algorithm>
#include <cmath>

#include "engine/world/step_inputs.h"

namespace tandem {

namespace {

/// Returns the radius round a body's frame's origin that others must not enter unseen, m. It holds
/// the surface voxels and the layers round them that may read contact.
double RadiusOf(const BodyModel& body) {
  const int most_layer = body.voxmap.range() - kWarningQueues;
  return body.points.radius + (most_layer + 2) * std::sqrt(3.0) * body.voxmap.voxel_size();
}

ContactGains GainsFor(const WorldModel& model, double mass) {
  ContactGains gains = DefaultContactGains(model.scene.voxel_size, mass, kFrame);
  gains.friction = model.scene.friction;
  return gains;
}

/// Returns the inward shift of a body's surface, voxels.
double ShiftOf(const WorldModel& model, std::size_t body) {
  return model.scene.bodies[model.object[body]].inward_shift_voxels;
}

}  // namespace

std::unique_ptr<BodyPair> MakeFixturePair(const WorldModel& model, std::size_t body,
                                          ResidentVoxels* resident,
                                          const ScheduleOptions& schedule) {
  const BodyModel& shell = model.bodies[body];
  const Voxmap& fixture = resident != nullptr ? resident->voxmap() : model.fixture;
  const Pose X_WV{Quat::Identity(), fixture.p_WVo()};
  const ContactGains gains = GainsFor(model, shell.inertia.mass);
  if (model.scene.contact == ContactModel::kRefined) {
    return std::make_unique<FieldPair>(
        shell.surface, model.fixture_surface,
        FieldPair::Options{.inward_shift = ShiftOf(model, body), .schedule = schedule}, gains);
  }
  const Extent extent = ExtentOf(shell.points);
  return std::make_unique<ContactPair>(
      shell.points, fixture, X_WV, 0,
      PairOptions{.force_layer = model.scene.force_layer,
                  .schedule = schedule,
                  .reader = resident != nullptr
                                ? &resident->AddReader(extent.centre, extent.half_size)
                                : nullptr},
      gains);
}

std::unique_ptr<BodyPair> MakeMovingPair(const WorldModel& model, std::size_t shell,
                                         std::size_t map, const ScheduleOptions& schedule) {
  const BodyModel& shell_model = model.bodies[shell];
  const BodyModel& map_model = model.bodies[map];
  const ContactGains gains =
      GainsFor(model, std::max(shell_model.inertia.mass, map_model.inertia.mass));
  if (model.scene.contact == ContactModel::kRefined) {
    return std::make_unique<FieldPair>(
        shell_model.surface, map_model.surface,
        FieldPair::Options{
            .both_move = true, .inward_shift = ShiftOf(model, shell), .schedule = schedule},
        gains);
  }
  return std::make_unique<ContactPair>(
      shell_model.points, map_model.voxmap, map_model.X_BV, RadiusOf(map_model),
      PairOptions{.force_layer = model.scene.force_layer, .both_move = true, .schedule = schedule},
      gains);
}

}  // namespace tandem
