#pragma once

#include <span>

#include "engine/contact/pair/body_pair.h"
#include "engine/contact/pair/tangent_plane.h"

namespace tandem {

/// The rule by which contacts become forces.
struct ForceRule {
  ContactGains gains;
  double voxel_size = 0;  // m
  /// Voxels of depth over which damping grows from nothing, so that contacts that begin exactly do
  /// not jerk; 0: damping is full from the start.
  double full_damping_depth = 0;
  /// Voxels of depth over which stiffness grows from nothing; 0: stiffness is full from the start.
  double full_stiffness_depth = 0;
};

/// The places of a pair: X_VS places the shell's body in the map's frame V.
struct PairPlaces {
  Pose X_VS;
  Pose X_WV;
  BodyMotion shell_body;
  BodyMotion map_body;
};

/// Adds the loads of contacts on both bodies, and sets the force of each contact. Returns how the
/// load on the shell changes as the map moves.
CrossJacobian AddContactForces(std::span<Contact> contacts, const PairPlaces& at,
                               const ForceRule& rule, LinearizedForce& on_shell,
                               LinearizedForce& on_map) noexcept;

}  // namespace tandem
