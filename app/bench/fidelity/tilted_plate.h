#pragma once

#include <memory>
#include <random>

#include "app/bench/fidelity/fidelity.h"
#include "engine/contact/pair/body_pair.h"

namespace tandem {

inline constexpr double kPlateVoxel = 0.001;  // m; figures of plates are in voxels

/// Draws a uniformly distributed rotation.
Quat DrawnRotation(std::mt19937_64& random);

/// A plate whose upper face is a plane of a random tilt, as a body that others meet.
struct TiltedPlate {
  /// `range_voxels`: the clearance range of both bodies' fields in the refined model.
  TiltedPlate(ContactModel contact, std::mt19937_64& random,
              double range_voxels = kDefaultClearanceRange);

  Quat q;
  Vec3 normal;
  Vec3 place;  // on the face, m
  double clearance_range;
  Voxmap voxmap;
  BodySurface surface;  // in place of the voxmap, in the refined model
};

/// A body over a plate, its points made at a random attitude to the grid. It is convex, so its
/// exact gap to the plane is a vertex's.
struct Pressing {
  Pressing(ContactModel contact, Approaching body, const TiltedPlate& on, std::mt19937_64& random);

  /// Returns the body's pose with that exact gap (m), beside the face's middle by `along`.
  Pose At(const Quat& q_WB, const Vec3& along, double gap) const;
  Vec3 ForceAt(const Pose& X_WB);
  /// Returns the mean depth over the contacts of the last force, voxels.
  double MeanDepth() const;

  const TiltedPlate& plate;
  TriangleMesh mesh_B;
  Pointshell shell;
  BodySurface surface;  // in place of the shell, in the refined model
  std::unique_ptr<BodyPair> pair;
};

}  // namespace tandem
