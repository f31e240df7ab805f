#pragma once

#include <span>

#include "engine/contact/body_pair.h"
#include "engine/contact/tangent_plane.h"

namespace tandem {

/// How contacts become forces.
struct ForceRule {
  ContactGains gains;
  double voxel_size = 0;  // m
  /// Voxels of depth over which damping grows from nothing; 0: it is there at once. Contacts that
  /// begin exactly do not jerk with it.
  double full_damping_depth = 0;
  /// Voxels of depth over which stiffness grows from nothing; 0: likewise.
  double full_stiffness_depth = 0;
};

/// Where a pair is: X_VS places the shell's body in the map's frame V.
struct PairPlaces {
  Pose X_VS;
  Pose X_WV;
  BodyMotion shell_body;
  BodyMotion map_body;
};

/// Adds what contacts put on both bodies, and gives how the load on the shell changes as the map
/// moves. Each contact gets its force.
CrossLoad AddContactForces(std::span<Contact> contacts, const PairPlaces& at, const ForceRule& rule,
                           Load& on_shell, Load& on_map) noexcept;

}  // namespace tandem
