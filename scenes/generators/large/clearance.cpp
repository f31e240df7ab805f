#include "scenes/generators/large/clearance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "engine/geometry/mesh/closest_on_triangle.h"

namespace tandem {
namespace {

Bounds BoxOf(const TriangleMesh& mesh, std::size_t t) {
  Bounds box;
  for (std::size_t k = 0; k < 3; ++k) box.Add(mesh.corner(t, k));
  return box;
}

std::vector<Vec3> Samples(const TriangleMesh& mesh, double spacing) {
  std::vector<Vec3> samples = mesh.vertices;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3& a = mesh.corner(t, 0);
    const Vec3& b = mesh.corner(t, 1);
    const Vec3& c = mesh.corner(t, 2);
    const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    const int n = static_cast<int>(std::ceil(longest / spacing));
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; i + j <= n; ++j) {
        const bool corner = (i == 0 && j == 0) || i == n || j == n;
        if (!corner) samples.emplace_back(a + (b - a) * i / n + (c - a) * j / n);
      }
    }
  }
  return samples;
}

}  // namespace

Clearance::Clearance(const TriangleMesh& fixed, const Bounds& where, const TriangleMesh& moving,
                     double spacing) {
  std::vector<Bounds> boxes;
  fixed_.vertices = fixed.vertices;
  for (std::size_t t = 0; t < fixed.triangles.size(); ++t) {
    const Bounds box = BoxOf(fixed, t);
    if (!box.Overlaps(where)) continue;
    boxes.push_back(box);
    fixed_.triangles.push_back(fixed.triangles[t]);
  }
  tree_ = BuildBoxTree(boxes, 4);

  const std::vector<Vec3> samples = Samples(moving, spacing);
  std::vector<Bounds> points(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) points[i].Add(samples[i]);
  const BoxTree clusters = BuildBoxTree(points, 48);
  for (const std::uint32_t i : clusters.order) samples_.push_back(samples[i]);
  for (const BoxTree::Node& node : clusters.nodes) {
    if (!node.leaf()) continue;
    clusters_.push_back({node.first, node.count, node.box.centre(), 0.5 * node.box.size().norm()});
  }
}

double Clearance::ToFixed(const Vec3& p, double cut_off) const {
  double least = cut_off * cut_off;
  if (tree_.nodes.empty()) return cut_off;
  std::array<std::uint32_t, BoxTree::kMaxDepth + 1> stack{};
  std::size_t depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const std::uint32_t at = stack[--depth];
    const BoxTree::Node& node = tree_.nodes[at];
    if (SquaredDistance(node.box, p) >= least) continue;
    if (!node.leaf()) {
      const bool left_first = SquaredDistance(tree_.nodes[at + 1].box, p) <=
                              SquaredDistance(tree_.nodes[node.right].box, p);
      stack[depth++] = left_first ? node.right : at + 1;
      stack[depth++] = left_first ? at + 1 : node.right;
      continue;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      const std::size_t t = tree_.order[i];
      const OnTriangle closest =
          ClosestOnTriangle(fixed_.corner(t, 0), fixed_.corner(t, 1), fixed_.corner(t, 2), p);
      least = std::min(least, (closest.point - p).squaredNorm());
    }
  }
  return std::sqrt(least);
}

double Clearance::At(const Pose& X, double cut_off) const {
  double least = cut_off;
  for (const Cluster& cluster : clusters_) {
    const double reach = least + cluster.radius;
    if (ToFixed(X * cluster.centre, reach) >= reach) continue;
    for (std::uint32_t i = cluster.first; i < cluster.first + cluster.count; ++i) {
      least = ToFixed(X * samples_[i], least);
    }
  }
  return least;
}

}  // namespace tandem
