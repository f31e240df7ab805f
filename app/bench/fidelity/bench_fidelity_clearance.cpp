#include <algorithm>
#include <cmath>
#include <random>

#include "app/bench/fidelity/factory_scene.h"
#include "app/bench/fidelity/fidelity.h"
#include "app/bench/fidelity/tilted_plate.h"
#include "engine/base/check.h"
#include "engine/contact/features/edge_contact.h"
#include "engine/world/world_of_meshes.h"
#include "scenes/generators/shapes.h"

namespace tandem {

namespace {

constexpr double kRange = 6;  // voxels, clearance range of the scene

/// Returns the gap of exact surfaces at which force begins as a body comes down, voxels.
/// `expected`: about that gap.
double FirstForceGap(Pressing& pressing, const Quat& q_WB, double expected) {
  constexpr double kStep = 0.02;  // voxels
  constexpr double kFar = 12;
  constexpr int kFramesAway = 700;  // frames after which a clearance no longer changes
  const auto pushes = [&](double gap) {
    const Pose X_WB = pressing.At(q_WB, Vec3::Zero(), gap * kPlateVoxel);
    return pressing.ForceAt(X_WB).dot(pressing.plate.normal) > 0;
  };
  for (int frame = 0; frame < kFramesAway; ++frame) pushes(kFar);
  double above = expected + 2;
  while (above > expected - 2 && !pushes(above - kStep)) above -= kStep;
  double below = above - kStep;
  for (int cut = 0; cut < 10; ++cut) {
    const double middle = 0.5 * (above + below);
    (pushes(middle) ? below : above) = middle;
  }
  return above;
}

/// Measures how far from the gap that a displacement sets force begins.
void MeasureGaps(int tilts, ClearanceFigures& figures) {
  constexpr int kSteps = 26;  // from the greatest displacement outward to the greatest inward
  const double layer = DefaultForceLayer(ContactModel::kRefined);
  std::mt19937_64 random(14);
  for (int tilt = 0; tilt < tilts; ++tilt) {
    const TiltedPlate plate(ContactModel::kRefined, random, kRange);
    for (const Approaching body : {Approaching::kSphere, Approaching::kBox}) {
      Pressing pressing(ContactModel::kRefined, body, plate, random);
      const ClearanceBounds bounds = pressing.pair->clearance_bounds();
      for (int step = 0; step <= kSteps; ++step) {
        const double share = static_cast<double>(step) / kSteps;
        const double displacement =
            share * (bounds.most_inward + bounds.most_outward) - bounds.most_outward;
        pressing.pair->SetClearance({layer, displacement});
        const double expected = kRefinedClearance - displacement / kPlateVoxel;
        const double gap = FirstForceGap(pressing, DrawnRotation(random), expected);
        double& most = expected <= kDefaultFineBand ? figures.error_voxels_max
                                                    : figures.outer_error_voxels_max;
        most = std::max(most, std::abs(gap - expected));
        figures.late_voxels_max = std::max(figures.late_voxels_max, expected - gap);
      }
    }
  }
}

/// Returns the largest change of the hand's force from frame to frame, N. The hand presses a box
/// onto a plate while the displacement goes from end to end. `turn` turns both.
double LargestStepOfHand(const Quat& turn) {
  constexpr int kSettling = 1500;
  constexpr int kChanging = 700;  // longer than the way from end to end at kClearancePace
  const auto turned = [&turn](const TriangleMesh& mesh) {
    return Transformed(mesh, {turn, Vec3::Zero()});
  };
  const auto made = WorldOfMeshes(
      {{.mesh_W = turned(Box(Vec3(-0.04, -0.04, -0.01), Vec3(0.04, 0.04, 0))), .fixed = true},
       {.mesh_W = turned(Box(Vec3(-0.008, -0.006, 0.005), Vec3(0.008, 0.006, 0.015)))}},
      kPlateVoxel, ContactModel::kRefined, kRange);
  TANDEM_CHECK(made.has_value());
  World world(*made);
  StepInputs inputs = HandInputs(**made);
  inputs.hand.goal.X_WA = {(*made)->bodies[0].X_WB0.q, -0.001 * (turn * Vec3::UnitZ())};
  TimesOfFrames times;
  Vec3 force = Vec3::Zero();
  const auto step = [&] {
    const Vec3 before = force;
    force = TimedStep(world, inputs, times).report.hand_B_W.f;
    return (force - before).norm();
  };
  for (int frame = 0; frame < kSettling; ++frame) step();
  const ClearanceBounds bounds = world.pair(0).clearance_bounds();
  double largest = 0;
  for (const double displacement : {-bounds.most_outward, bounds.most_inward, 0.0}) {
    inputs.clearance.displacement = displacement;
    for (int frame = 0; frame < kChanging; ++frame) largest = std::max(largest, step());
  }
  return largest;
}

}  // namespace

ClearanceFigures MeasureClearance(int tilts) {
  std::mt19937_64 random(15);
  ClearanceFigures figures;
  MeasureGaps(tilts, figures);
  for (int tilt = 0; tilt < tilts; ++tilt) {
    const Quat turn = tilt == 0 ? Quat::Identity() : DrawnRotation(random);
    figures.force_step = std::max(figures.force_step, LargestStepOfHand(turn));
  }
  return figures;
}

}  // namespace tandem
