#include "engine/field/field_faces.h"

#include <algorithm>
#include <utility>

#include "engine/geometry/union_boundary.h"
#include "engine/geometry/winding_number.h"
#include "engine/voxel/inside_winding.h"

namespace tandem {

std::vector<FieldFace> FindFieldFaces(const TriangleMesh& mesh_W, const MeshFacing& facing,
                                      double voxel_size, const GridIndex& origin) {
  const TriangleMesh turned = FacingOut(mesh_W, facing);
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
  std::vector<FieldFace> faces;
  const Vec3 first(origin.x + 0.5, origin.y + 0.5, origin.z + 0.5);
  const auto place_L = [&](const Vec3& p_W) -> Vec3 {
    return p_W / voxel_size - first;
  };
  for (const Facet& facet : UnionBoundaryAndSheets(turned, solid)) {
    faces.push_back(
        {{place_L(facet.a), place_L(facet.b), place_L(facet.c)}, facet.nhat, facet.sheet});
    auto& [a, b, c] = faces.back().corners_L;
    const Vec3 area_vector = (b - a).cross(c - a);
    if (area_vector.dot(facet.nhat) < 0) std::swap(b, c);
    const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    faces.back().width = longest > 0 ? area_vector.norm() / longest : 0.0;
  }
  return faces;
}

}  // namespace tandem
