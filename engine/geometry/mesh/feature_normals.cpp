#include "engine/geometry/mesh/feature_normals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace tandem {

namespace {

constexpr std::uint32_t kNoFeature = ~0U;

}  // namespace

FeatureNormals FindFeatureNormals(const TriangleMesh& mesh, const Features& features) {
  FeatureNormals normals;
  normals.edges.assign(features.edges.size(), Vec3::Zero());
  normals.edge_cosines.assign(features.edges.size(), 0.0);
  /// The triangles at an edge: their number, the first one's normal and its corner off the edge.
  struct AtEdge {
    int triangles = 0;
    Vec3 normal = Vec3::Zero();
    Vec3 corner = Vec3::Zero();
  };
  std::vector<AtEdge> at_edge(features.edges.size());
  normals.vertices.assign(features.vertices.size(), Vec3::Zero());
  std::vector<std::uint32_t> feature_of(mesh.vertices.size(), kNoFeature);
  std::vector<std::uint8_t> on_edge(mesh.vertices.size(), 0);
  for (std::uint32_t i = 0; i < features.vertices.size(); ++i) feature_of[features.vertices[i]] = i;
  for (const auto& [a, b] : features.edges) on_edge[a] = on_edge[b] = 1;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const TriangleMesh::Triangle& corners = mesh.triangles[t];
    const Vec3 area =
        (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0));
    if (!(area.norm() > 0)) continue;
    const Vec3 n = area.normalized();
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = corners[k];
      const std::uint32_t b = corners[(k + 1) % 3];
      if (feature_of[a] != kNoFeature) {
        const Vec3 one = (mesh.vertices[b] - mesh.vertices[a]).normalized();
        const Vec3 two = (mesh.corner(t, (k + 2) % 3) - mesh.vertices[a]).normalized();
        normals.vertices[feature_of[a]] += std::acos(std::clamp(one.dot(two), -1.0, 1.0)) * n;
      }
      if (on_edge[a] == 0 || on_edge[b] == 0) continue;
      const std::array<std::uint32_t, 2> ends{std::min(a, b), std::max(a, b)};
      const auto found = std::lower_bound(features.edges.begin(), features.edges.end(), ends);
      if (found != features.edges.end() && *found == ends) {
        const auto e = static_cast<std::size_t>(found - features.edges.begin());
        normals.edges[e] += n;
        AtEdge& at = at_edge[e];
        if (++at.triangles == 1) {
          at.normal = n;
          at.corner = mesh.corner(t, (k + 2) % 3);
        } else if (at.triangles == 2) {
          const bool ridge = n.dot(at.corner - mesh.vertices[a]) < 0;
          const double cosine = std::sqrt(std::max(0.0, 0.5 * (1.0 + n.dot(at.normal))));
          normals.edge_cosines[e] = ridge ? cosine : -cosine;
        } else {
          normals.edge_cosines[e] = 0;
        }
      }
    }
  }
  for (Vec3& n : normals.edges) n.normalize();
  for (Vec3& n : normals.vertices) n.normalize();
  return normals;
}

}  // namespace tandem
