#pragma once

#include <cstdint>
#include <vector>

#include "engine/geometry/mesh/mesh_sides.h"
#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// The sides that the triangles of a mesh face, and which of its bodies (connected over shared
/// vertices) bound a volume.
struct MeshFacing {
  /// Per triangle: 1 if its normal points out of the solid, -1 if into it. Triangles that are wound
  /// against their neighbours are turned. Closed bodies that are inside out are turned as wholes,
  /// except cavities, which lie in the box of a sound body.
  std::vector<std::int8_t> of_triangle;
  /// Per triangle: its body has a boundary, so that only a winding number decides its inside. Empty
  /// if no body has one.
  std::vector<std::uint8_t> open;
};

MeshFacing FindFacing(const TriangleMesh& mesh, const MeshSides& sides);

/// Returns the mesh with every triangle facing out of the solid.
TriangleMesh OrientOutward(const TriangleMesh& mesh, const MeshFacing& facing);

}  // namespace tandem
