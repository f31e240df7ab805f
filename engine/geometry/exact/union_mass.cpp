#include "engine/geometry/exact/union_mass.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "engine/geometry/exact/union_boundary.h"
#include "engine/geometry/exact/winding_number.h"
#include "engine/geometry/mesh/mesh_sides.h"

namespace tandem {

namespace {

/// Returns the box of each set of triangles that are connected across their sides.
std::vector<Bounds> BoxesOfSolids(const TriangleMesh& mesh, const MeshSides& sides) {
  constexpr std::uint32_t kUnseen = ~0U;
  std::vector<std::uint32_t> solid_of(mesh.triangles.size(), kUnseen);
  std::vector<Bounds> boxes;
  std::vector<std::uint32_t> open;
  for (std::uint32_t first = 0; first < solid_of.size(); ++first) {
    if (solid_of[first] != kUnseen) continue;
    const auto solid = static_cast<std::uint32_t>(boxes.size());
    boxes.emplace_back();
    solid_of[first] = solid;
    open.assign(1, first);
    while (!open.empty()) {
      const std::uint32_t t = open.back();
      open.pop_back();
      for (std::uint32_t k = 0; k < 3; ++k) {
        boxes.back().Add(mesh.corner(t, k));
        const std::uint32_t next = sides.NeighborAcross(t, k);
        if (next == MeshSides::kNone || solid_of[next] != kUnseen) continue;
        solid_of[next] = solid;
        open.push_back(next);
      }
    }
  }
  return boxes;
}

/// Tells whether any two boxes have a volume in common.
bool AnyOverlap(std::vector<Bounds> boxes, double tolerance) {
  std::ranges::sort(boxes, {}, [](const Bounds& box) {
    return box.min.x();
  });
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    for (std::size_t j = i + 1; j < boxes.size(); ++j) {
      if (boxes[j].min.x() >= boxes[i].max.x() - tolerance) break;
      const Vec3 common = boxes[i].max.cwiseMin(boxes[j].max) - boxes[i].min.cwiseMax(boxes[j].min);
      if (common.minCoeff() > tolerance) return true;
    }
  }
  return false;
}

/// Returns the surface that bounds the union of the mesh's solids.
TriangleMesh BoundaryOf(const TriangleMesh& outward, const MeshSides& sides) {
  const WindingNumber winding(outward);
  // cracks close by their winding number, which changes at no triangle
  const MeshSides* patches = sides.walls().empty() ? &sides : nullptr;
  const std::vector<Facet> facets = UnionBoundaryAndSheets(outward, patches, [&](const Vec3& p) {
    return winding.At(p) >= 0.5;
  });
  TriangleMesh boundary;
  for (const Facet& facet : facets) {
    if (facet.sheet) continue;
    const auto first = static_cast<std::uint32_t>(boundary.vertices.size());
    boundary.vertices.insert(boundary.vertices.end(), {facet.a, facet.b, facet.c});
    const bool turned = (facet.b - facet.a).cross(facet.c - facet.a).dot(facet.nhat) < 0;
    boundary.triangles.push_back({first, first + (turned ? 2 : 1), first + (turned ? 1 : 2)});
  }
  return boundary;
}

}  // namespace

MassProperties ComputeUnionMass(const TriangleMesh& mesh) {
  constexpr double kSame = 1e-6;  // share of the volume that the cuts may round away
  MassProperties plain = ComputeMassProperties(mesh);
  if (!plain.solid) return plain;
  const TriangleMesh outward = OrientBodiesOutward(mesh);
  const MeshSides sides(outward);
  if (!AnyOverlap(BoxesOfSolids(outward, sides), CoincidenceTolerance(mesh))) return plain;
  const TriangleMesh boundary = BoundaryOf(outward, sides);
  if (boundary.triangles.empty()) return plain;
  MassProperties whole = ComputeBoundedMass(boundary);
  if (!whole.solid || std::abs(whole.volume - std::abs(plain.volume)) <= kSame * whole.volume) {
    return plain;
  }
  whole.volume = std::copysign(whole.volume, plain.volume);
  return whole;
}

}  // namespace tandem
