#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "engine/geometry/mesh_sides.h"
#include "engine/geometry/triangle_mesh.h"
#include "engine/geometry/winding_number.h"

namespace tandem {

/// A flat piece of the surface that bounds a union of bodies.
struct Facet {
  Vec3 a, b, c;
  Vec3 nhat;                   // out of the union
  bool sheet = false;          // the union is on neither side
  std::uint32_t triangle = 0;  // of the mesh
  bool whole = true;           // all of the triangle
};

/// Lengths below this (m) do not count in geometry of that size: faces of two bodies that are
/// nearer than this lie on one another, and a gap as thin is closed.
double CoincidenceTolerance(const TriangleMesh& mesh);

/// The mesh with every body that is turned inside out, though it lies in no other body, turned
/// right. A body is what hangs together over shared vertices. Open ones are left as they are.
TriangleMesh WithBodiesTurnedOut(const TriangleMesh& mesh);

/// The pieces of the mesh's triangles that bound the union of its bodies: solid (winding number at
/// least one half) behind, not solid in front. A face of one body inside another one bounds nothing
/// and is left out; a triangle that others cross is cut along them first, so that each piece is
/// wholly the one or the other. Sheets that enclose nothing have no such pieces.
std::vector<Facet> UnionBoundary(const TriangleMesh& mesh, const WindingNumber& winding);

/// The same of the union that `solid` tells, which several threads ask at once; and the pieces with
/// free space on both sides, as sheets. `sides` are the mesh's; null: every piece is asked for by
/// itself. Otherwise `solid` must change at triangles alone, as it does not where open bodies are
/// closed by their winding number; triangles that hang together and meet no others are then asked
/// for once.
std::vector<Facet> UnionBoundaryAndSheets(const TriangleMesh& mesh, const MeshSides* sides,
                                          const std::function<bool(const Vec3&)>& solid);

}  // namespace tandem
