#include "app/judgement/sample_tree.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/base/check.h"

namespace tandem {
namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

double Steps(double length, double spacing) {
  return std::max(1.0, std::ceil(length / spacing));
}

std::vector<Edge> EdgesOf(const TriangleMesh& mesh) {
  std::vector<Edge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const TriangleMesh::Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) edges.push_back(std::minmax({t[k], t[(k + 1) % 3]}));
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

// Adds rows of samples parallel to the longest edge, between it and the opposite corner.
void SampleInside(Vec3 a, Vec3 b, Vec3 c, double spacing, std::vector<Vec3>& samples) {
  const auto longest_is_ab = [&] {
    const double ab = (b - a).squaredNorm();
    return ab >= (c - b).squaredNorm() && ab >= (a - c).squaredNorm();
  };
  while (!longest_is_ab()) {
    const Vec3 first = a;
    a = b;
    b = c;
    c = first;
  }
  const double base = (b - a).norm();
  if (base == 0) return;
  const double rows = Steps((b - a).cross(c - a).norm() / base, spacing);
  for (double row = 1; row < rows; ++row) {
    const Vec3 from = a + (row / rows) * (c - a);
    const Vec3 to = b + (row / rows) * (c - b);
    const double steps = Steps((to - from).norm(), spacing);
    for (double i = 0; i <= steps; ++i) samples.push_back(from + (i / steps) * (to - from));
  }
}

}  // namespace

std::vector<Vec3> SampleSurface(const TriangleMesh& mesh, double spacing) {
  TANDEM_CHECK(spacing > 0);
  std::vector<Vec3> samples;
  std::vector<bool> used(mesh.vertices.size(), false);
  for (const TriangleMesh::Triangle& t : mesh.triangles) {
    for (const std::uint32_t vertex : t) used[vertex] = true;
  }
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (used[i]) samples.push_back(mesh.vertices[i]);
  }
  for (const Edge& edge : EdgesOf(mesh)) {
    const Vec3& from = mesh.vertices[edge.first];
    const Vec3& to = mesh.vertices[edge.second];
    const double steps = Steps((to - from).norm(), spacing);
    for (double i = 1; i < steps; ++i) samples.push_back(from + (i / steps) * (to - from));
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    SampleInside(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), spacing, samples);
  }
  return samples;
}

SampleTree::SampleTree(std::vector<Vec3> points) {
  if (points.empty()) return;
  nodes_.resize(2 * points.size() - 1);
  Build({0, points.size()}, points.data());
}

void SampleTree::Build(Branch branch, Vec3* first) {
  Vec3* const end = first + branch.points;
  Bounds box;
  for (const Vec3* p = first; p != end; ++p) box.Add(*p);
  Node& node = nodes_[branch.node];
  if (branch.leaf()) {
    node = {*first, 0.0};
    return;
  }
  node.centre = box.centre();
  double squared = 0;
  for (const Vec3* p = first; p != end; ++p) {
    squared = std::max(squared, (*p - node.centre).squaredNorm());
  }
  node.radius = std::sqrt(squared) * (1 + 1e-12);
  Eigen::Index axis = 0;
  box.size().maxCoeff(&axis);
  Vec3* const middle = first + branch.points / 2;
  std::nth_element(first, middle, end, [axis](const Vec3& p, const Vec3& q) {
    return p[axis] < q[axis];
  });
  Build(branch.Left(), first);
  Build(branch.Right(), middle);
}

}  // namespace tandem
