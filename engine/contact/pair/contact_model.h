#pragma once

#include <cstdint>
#include <span>

#include "engine/contact/pair/contact_kind.h"
#include "engine/voxel/map/voxmap.h"

namespace tandem {

/// A point that reads contact in its own field.
struct Candidate {
  std::uint32_t block;  // block of PointBlocks
  std::uint32_t lane;
  int mark;
  GridIndex voxel_V;
  Vec3 p_V;     // m
  Vec3 nhat_V;  // its inward normal
};

/// A contact: a place where two bodies push each other.
struct Contact {
  Vec3 p_V;          // m
  Vec3 nhat_V;       // unit: the direction in which the pointshell's body is pushed
  double depth;      // depth, m, above 0
  double share = 1;  // share of the push, less than 1 where others push at the same place
  double force = 0;  // size of the force from its depth, N; set by AddContactForces()
};

/// Finds the paper's contacts: one for each candidate below its tangent plane, along its own
/// normal. `layers`: the force layer, or a value between two. Returns their number; `out` has room
/// for as many as there are candidates.
std::size_t FindPlainContacts(std::span<const Candidate> candidates, const Voxmap& voxmap,
                              double layers, Contact* out) noexcept;

}  // namespace tandem
