#include "engine/field/build/field_faces.h"

#include <algorithm>
#include <utility>

#include "engine/geometry/exact/union_boundary.h"
#include "engine/geometry/exact/winding_number.h"
#include "engine/voxel/build/inside_winding.h"

namespace tandem {

namespace {

/// Sets for each face the faces that continue it gently over its edges. Only whole triangles have
/// such edges. `turned` tells for each facet whether its corners are in the other order.
void FindFacesBeside(const MeshSides& sides, const std::vector<Facet>& facets,
                     const std::vector<bool>& turned, std::vector<FieldFace>& faces) {
  std::vector<std::uint32_t> face_of(sides.triangles(), FieldFace::kNone);
  for (std::uint32_t i = 0; i < facets.size(); ++i) {
    if (facets[i].whole && !facets[i].sheet) face_of[facets[i].triangle] = i;
  }
  for (std::uint32_t i = 0; i < facets.size(); ++i) {
    if (face_of[facets[i].triangle] != i) continue;
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t other = sides.NeighborAcross(facets[i].triangle, turned[i] ? 2 - k : k);
      if (other == MeshSides::kNone || face_of[other] == FieldFace::kNone) continue;
      const FieldFace& beside = faces[face_of[other]];
      if (faces[i].nhat.dot(beside.nhat) > FieldFace::kGentle) faces[i].beside[k] = face_of[other];
    }
  }
}

}  // namespace

std::vector<FieldFace> FindFieldFaces(const TriangleMesh& mesh_W, const MeshFacing& facing,
                                      double voxel_size, const GridIndex& origin) {
  const TriangleMesh turned = OrientOutward(mesh_W, facing);
  TriangleMesh closed{mesh_W.vertices, {}};
  TriangleMesh open{mesh_W.vertices, {}};
  for (std::size_t t = 0; t < turned.triangles.size(); ++t) {
    const bool is_open = !facing.open.empty() && facing.open[t] != 0;
    (is_open ? open : closed).triangles.push_back(turned.triangles[t]);
  }
  const WindingNumber round_closed(closed);
  const WindingNumber round_open(open);
  const auto solid = [&](const Vec3& p_W) {
    return (!closed.triangles.empty() && round_closed.At(p_W) >= 0.5) ||
           (!open.triangles.empty() && round_open.At(p_W) > kInside);
  };
  // with open bodies the union also changes beside triangles: then no sides are given
  const MeshSides sides(turned);
  const std::vector<Facet> facets =
      UnionBoundaryAndSheets(turned, open.triangles.empty() ? &sides : nullptr, solid);
  std::vector<FieldFace> faces;
  std::vector<bool> is_turned;
  const Vec3 first(origin.x + 0.5, origin.y + 0.5, origin.z + 0.5);
  const auto place_L = [&](const Vec3& p_W) -> Vec3 {
    return p_W / voxel_size - first;
  };
  for (const Facet& facet : facets) {
    faces.push_back(
        {{place_L(facet.a), place_L(facet.b), place_L(facet.c)}, facet.nhat, facet.sheet});
    auto& [a, b, c] = faces.back().corners_L;
    const Vec3 area_vector = (b - a).cross(c - a);
    is_turned.push_back(area_vector.dot(facet.nhat) < 0);
    if (is_turned.back()) std::swap(b, c);
    const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    faces.back().width = longest > 0 ? area_vector.norm() / longest : 0.0;
  }
  FindFacesBeside(sides, facets, is_turned, faces);
  return faces;
}

}  // namespace tandem
