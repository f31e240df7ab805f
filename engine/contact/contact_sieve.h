#pragma once

#include <array>
#include <cstdint>

#include "engine/base/spatial.h"
#include "engine/contact/edge_contact.h"
#include "engine/contact/near_pieces.h"

namespace tandem {

// Which points of a shell can push, sorted out many pieces at a time. A body in close fit has
// thousands of points within a voxel of another's surface, of which some tens push; only those are
// worth an exact look (RefinedContacts). Whoever can push is let through; some of those let through
// do not. Single precision, with margins far above its rounding.

/// Of the questions, voxels and cosines: more than is rounded some voxels from a group's middle.
inline constexpr double kSieveMargin = 1e-3;

/// A point of the shell, in voxels of V, that is in the cell whose pieces are asked.
struct SievedPoint {
  GridIndex voxel_V;
  Vec3 p;
  Vec3 nhat;  // inward
};

/// Whether a vertex of the shell can stand on the surface; not for what is inside.
bool MayStand(const NearPieces::Cell& surface, const SievedPoint& vertex) noexcept;

/// Whether a piece of the shell's edge can push the map's edges.
struct SievedEdge {
  Vec3 tangent;
  double half;
  EdgeArc arc;
};
bool MayLean(const NearPieces::Cell& edges, const SievedPoint& middle,
             const SievedEdge& edge) noexcept;

/// What a face of the shell can say of the map's vertices: of none, of some that it is high above,
/// or of some that it bears on.
enum class SievedBearing : std::uint8_t { kNone, kHigh, kBears };
SievedBearing MayBear(const NearPieces::Cell& vertices, const SievedPoint& point) noexcept;

/// What is asked, in the columns' terms.
struct SieveProbe {
  std::array<float, 3> voxel;
  std::array<float, 3> p;
  std::array<float, 3> nhat;
  std::array<float, 3> tangent;
  float half;
  float arc_tangent;  // of half of the arc's half
  float arc_cosine;
  float arc_last;
};

}  // namespace tandem
