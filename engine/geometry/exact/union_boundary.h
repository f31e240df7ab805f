#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "engine/geometry/exact/winding_number.h"
#include "engine/geometry/exact/work_budget.h"
#include "engine/geometry/mesh/mesh_sides.h"
#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// A flat piece of the surface that bounds a union of bodies.
struct Facet {
  Vec3 a, b, c;
  Vec3 nhat;                   // normal, out of the union
  bool sheet = false;          // the union is on neither side
  std::uint32_t triangle = 0;  // triangle of the mesh
  bool whole = true;           // it is all of the triangle
};

/// Returns the length (m) below which geometry of that size counts as coincident. Faces of two
/// bodies that are nearer than this lie on one another, and a gap as thin is closed.
double CoincidenceTolerance(const TriangleMesh& mesh);

/// Returns the mesh in which bodies that are turned inside out, but lie in no other body, are
/// turned right. A body is a set of triangles connected over shared vertices. Open bodies stay as
/// they are.
TriangleMesh OrientBodiesOutward(const TriangleMesh& mesh);

/// Returns the pieces of the mesh's triangles that bound the union of its bodies. A piece bounds it
/// if there is solid (winding number at least one half) behind it and none in front. A face of one
/// body inside another bounds nothing and is left out. A triangle that others cross is first cut
/// along them, so that each piece bounds the union as a whole or not at all. Sheets that enclose
/// nothing have no such pieces.
std::vector<Facet> UnionBoundary(const TriangleMesh& mesh, const WindingNumber& winding);

/// Returns the same for the union that `solid` defines, which several threads call at once, and the
/// pieces with free space on both sides, as sheets. `sides` are the mesh's; null: `solid` is called
/// for every piece. Otherwise `solid` must change at triangles alone. It does not do so where open
/// bodies are closed by their winding number. Then one call decides for triangles that are
/// connected and meet no others. Where `budget` is exceeded, the pieces are not whole.
std::vector<Facet> UnionBoundaryAndSheets(const TriangleMesh& mesh, const MeshSides* sides,
                                          const std::function<bool(const Vec3&)>& solid,
                                          WorkBudget* budget = nullptr);

}  // namespace tandem
