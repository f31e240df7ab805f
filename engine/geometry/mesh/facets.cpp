#include "engine/geometry/mesh/facets.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "engine/base/huge_vector.h"
#include "engine/geometry/mesh/feature_lines.h"
#include "engine/geometry/mesh/polygon_growth.h"

namespace tandem {

Features FindFeatures(const TriangleMesh& mesh, double tolerance) {
  return FindFeatures(mesh, MeshSides(mesh), tolerance);
}

Features FindFeatures(const TriangleMesh& mesh, const MeshSides& sides, double tolerance) {
  Features features;
  features.polygons = GrowPolygons(mesh, sides, tolerance, features.polygon_of);

  // sorts by the lesser end, and then by the greater one
  HugeVector<std::uint32_t> first(mesh.vertices.size() + 1, 0);
  HugeVector<FeatureLines::Edge> found;
  found.reserve(mesh.triangles.size() / 2);
  const auto add = [&](const FeatureLines::Edge& edge) {
    found.push_back(edge);
    ++first[edge.ends[0] + 1];
  };
  for (const MeshSides::Wall& wall : sides.walls())
    add({wall.ends, {MeshSides::kNone, MeshSides::kNone}});
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t one = features.polygon_of[t];
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t other = sides.NeighborAcross(t, k);
      if (other == MeshSides::kNone || other < t) continue;
      const std::uint32_t two = features.polygon_of[other];
      if (one == two) continue;
      const std::uint32_t a = mesh.triangles[t][k];
      const std::uint32_t b = mesh.triangles[t][k == 2 ? 0 : k + 1];
      add({{std::min(a, b), std::max(a, b)}, {std::min(one, two), std::max(one, two)}});
    }
  }
  std::partial_sum(first.begin(), first.end(), first.begin());
  HugeVector<FeatureLines::Edge> edges(found.size());
  HugeVector<std::uint32_t> next(first.begin(), first.end() - 1);
  for (const FeatureLines::Edge& e : found) edges[next[e.ends[0]]++] = e;
  for (std::size_t v = 0; v + 1 < first.size(); ++v) {
    if (first[v + 1] - first[v] < 2) continue;
    std::sort(edges.begin() + first[v], edges.begin() + first[v + 1],
              [](const auto& a, const auto& b) {
                return a.ends[1] < b.ends[1];
              });
  }
  features.edges.reserve(edges.size());
  for (const FeatureLines::Edge& e : edges) features.edges.push_back(e.ends);
  features.vertices = FeatureLines(mesh, std::move(edges)).FindVertices(tolerance);
  return features;
}

}  // namespace tandem
