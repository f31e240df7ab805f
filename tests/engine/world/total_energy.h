#pragma once

#include <algorithm>
#include <cmath>

#include "engine/contact/field/field_pair.h"
#include "tests/support/test_world.h"

namespace tandem::testing {

/// Returns the energy of a contact's spring, J: the integral of ContactForce() over its depth, in
/// closed form, for depths below three voxels.
inline double SpringEnergy(const Contact& contact, double voxel_size) {
  const double d = contact.depth;
  const double soft = kFullStiffnessDepth * voxel_size;
  const double less =
      d < soft ? d * d / 2 - d * d * d / (6 * soft) : soft * soft / 3 + soft * (d - soft) / 2;
  const double integral = d * d / 2 + 1.6 * std::pow(d, 5) / std::pow(voxel_size, 3) - less;
  return contact.force * integral / ContactForce(1.0, d, voxel_size, soft);
}

/// Follows the energy of a free body in a world of the refined contact model: that of its motion,
/// its height and the springs of its contact with the fixture. It starts where the body stands when
/// the first step is followed.
class TotalEnergy {
 public:
  TotalEnergy(const WorldModel& model, const RigidState& first) : model_(&model), first_(first) {}

  /// Steps the world, and takes the energy at the step's beginning, where its contacts are.
  void Step(World& world, const StepInputs& inputs) {
    const RigidState before = world.state(0);
    world.Step(inputs);
    const double fallen =
        model_->bodies[0].inertia.mass * model_->scene.gravity_W.dot(before.X_WB.p - first_.X_WB.p);
    double now = KineticEnergy(*model_, 0, before) - fallen;
    if (model_->has_fixture) {
      for (const Contact& contact : world.field_pair(0).contacts()) {
        now += SpringEnergy(contact, model_->scene.voxel_size);
      }
    }
    if (!begun_) start_ = now;
    begun_ = true;
    risen_ = std::max(risen_, now - start_);
    exchanged_ = std::max(exchanged_, std::abs(fallen));
    now_ = now;
  }
  /// Returns the most by which the energy has been above its start, as a share of the energy that
  /// gravity gave or took.
  double risen() const { return risen_ / exchanged_; }
  /// Returns the energy lost so far, as such a share.
  double lost() const { return (start_ - now_) / exchanged_; }

 private:
  const WorldModel* model_;
  RigidState first_;
  bool begun_ = false;
  double start_ = 0;
  double now_ = 0;
  double risen_ = 0;
  double exchanged_ = 0;
};

}  // namespace tandem::testing
