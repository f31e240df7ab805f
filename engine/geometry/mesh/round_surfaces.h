#pragma once

#include <cstddef>
#include <vector>

#include "engine/base/spatial.h"
#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// A sphere, or the side of a cylinder, that triangles of a mesh approximate all the way round,
/// with no flat, slot or hole in it.
struct RoundSurface {
  Vec3 centre = Vec3::Zero();  // the sphere's, or the middle of the cylinder's axis
  Vec3 axis = Vec3::Zero();    // unit, along the cylinder; zero for a sphere
  double half_length = 0;      // the cylinder's
  double radius = 0;
  double sagitta = 0;  // the greatest distance from the surface to a triangle's plane

  bool is_sphere() const noexcept { return axis.isZero(); }
};

/// The rules by which triangles count as a round surface; lengths in the mesh's unit.
struct RoundSurfaceRules {
  double most_sagitta = 0;  // the greatest distance from the surface to a triangle's plane
  double most_off = 0;      // the greatest distance of a vertex from the surface
  double least_radius = 0;  // smaller surfaces are left out
  std::size_t most_triangles = 100'000;  // larger meshes are not searched
};

/// The greatest angle between neighbouring triangles of a round surface, degrees. The sides of a
/// prism of eighteen or fewer are flat.
inline constexpr double kMostRoundTurn = 20;

/// Finds the round surfaces that triangles make with one another, each a part of the mesh that
/// turns by less than kMostRoundTurn from triangle to triangle. The borders of a cylinder lie in
/// the planes of its ends, and a sphere has none. No triangle lies much deeper under the surface
/// than most of the others: that would be a flat. The search does not tell which side is solid. The
/// result is deterministic.
std::vector<RoundSurface> FindRoundSurfaces(const TriangleMesh& mesh,
                                            const RoundSurfaceRules& rules);

}  // namespace tandem
