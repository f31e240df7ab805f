#pragma once

#include <string>

#include "engine/contact/pair/contact_kind.h"

namespace tandem {

/// The force with which a hand pulls a part unless its user sets another, N.
inline constexpr double kHandForce = 10.0;

/// How contact of a scene gives way.
struct ContactYield {
  ContactModel contact = ContactModel::kRefined;
  int force_layer = 0;
  double inward_shift_voxels = 0;  // the moving body's
  double voxel_size = 0;           // m

  /// Returns how deep exact surfaces may lie in one another where a force (N) rests on a single
  /// place, m. Contact is a spring: the force brings the place below where force begins. In a
  /// narrow fit force begins at a fiftieth of a voxel (decision 0053). More places share the
  /// force, and heavier bodies have stiffer contact, so surfaces lie less deep as a rule.
  double PressedDepth(double force = kHandForce) const noexcept;

  /// Returns the largest voxel (m), to two digits, at which contact gives way by at most half of a
  /// depth (m): surfaces that are as deep there cross, whatever the hand does. 0: contact gives way
  /// by nothing.
  double VoxelThatDecides(double depth, double force = kHandForce) const noexcept;

  /// Returns "contact gives 0.1 mm at 10 N; voxel_m 0.00014 decides", for a label.
  std::string Brief(double depth, double force = kHandForce) const;
  /// Returns "contact gives way by up to 0.1 mm under 10 N, so ...; a voxel_m of 0.00014 or less
  /// decides", for surfaces that cross by `depth` (m).
  std::string Describe(double depth, double force = kHandForce) const;
};

}  // namespace tandem
