#pragma once

#include <cstdint>
#include <vector>

#include "engine/geometry/mesh_sides.h"
#include "engine/geometry/triangle_mesh.h"

namespace tandem {

/// Which way the triangles of a mesh face, and which of its bodies (connected over shared vertices)
/// bound a volume.
struct MeshFacing {
  /// By triangle: 1 if its normal points out of the solid, -1 if into it. Triangles that are wound
  /// against their neighbours are turned; closed bodies that are inside out are turned as wholes
  /// unless they lie in the box of a sound one: those are cavities.
  std::vector<std::int8_t> of_triangle;
  /// By triangle: its body has a boundary, so that only a winding number can tell its inside. Empty
  /// if no body has.
  std::vector<std::uint8_t> open;
};

MeshFacing FindFacing(const TriangleMesh& mesh, const MeshSides& sides);

/// Returns the mesh with every triangle facing out of the solid.
TriangleMesh FacingOut(const TriangleMesh& mesh, const MeshFacing& facing);

}  // namespace tandem
