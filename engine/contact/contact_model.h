#pragma once

#include <cstdint>
#include <span>

#include "engine/contact/contact_kind.h"
#include "engine/voxel/voxmap.h"

namespace tandem {

/// A point that reads contact in its own field.
struct Candidate {
  std::uint32_t block;  // of PointBlocks
  std::uint32_t lane;
  std::uint32_t point;
  std::uint32_t edge;  // of an edge point: into Pointshell::edges
  Label label;
  int mark;  // of a vertex, and in the plain model; otherwise not read
  GridIndex voxel_V;
  Vec3 p_V;     // m
  Vec3 nhat_V;  // its inward normal
  /// Told by RefinedContacts: voxels that surfaces may come nearer before this point, which makes
  /// no contact and bears on none, can do so.
  double slack = 0;
  /// Told by RefinedContacts: what it took to know.
  enum class Look : std::uint8_t {
    kPassed,  // nothing: it stands where it is known to make none
    kSifted,  // a bound of its gap, which the next frame needs again
    kKept,    // an exact look, that told where else it makes none
    kOpen     // an exact look, that the next frame needs again
  };
  Look look = Look::kOpen;
};

/// Where two bodies push each other.
struct Contact {
  Vec3 p_V;          // m
  Vec3 nhat_V;       // unit: the way in which the pointshell's body is pushed
  double depth;      // m, above 0
  double share = 1;  // of the push, as far as others push at the same place
  double force = 0;  // N, what its depth comes to, once AddContactForces() was there
};

/// The paper's contacts: one for each candidate below its tangent plane, along its own normal.
/// `layers`: the force layer, or between two. Gives how many; `out` has room for as many as there
/// are candidates.
std::size_t FindPlainContacts(std::span<const Candidate> candidates, const Voxmap& voxmap,
                              double layers, Contact* out) noexcept;

}  // namespace tandem
