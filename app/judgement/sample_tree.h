#pragma once

#include <cstdint>
#include <vector>

#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// Returns points on a mesh: all vertices that triangles use, points along every edge, and rows of
/// points over every triangle. Neighbours and neighbouring rows are at most `spacing` (m) apart. So
/// no point of the surface is farther than spacing / sqrt(2) from a sample. The same mesh gives the
/// same samples.
std::vector<Vec3> SampleSurface(const TriangleMesh& mesh, double spacing);

/// A binary tree of spheres over points, halved by number; each leaf is one point.
class SampleTree {
 public:
  struct Node {
    Vec3 centre;    // p_BC, m
    double radius;  // m; 0 in a leaf
  };
  /// The index of a node, and the number of points in it.
  struct Branch {
    std::size_t node = 0;
    std::size_t points = 0;
    bool leaf() const { return points == 1; }
    Branch Left() const { return {node + 1, points / 2}; }
    Branch Right() const { return {node + 2 * (points / 2), points - points / 2}; }
  };

  explicit SampleTree(std::vector<Vec3> points);

  std::size_t points() const { return (nodes_.size() + 1) / 2; }
  std::size_t node_count() const { return nodes_.size(); }
  /// Returns the whole tree. There must be a point in it.
  Branch root() const { return {0, points()}; }
  const Node& operator[](std::size_t node) const { return nodes_[node]; }

 private:
  void Build(Branch branch, Vec3* first);

  std::vector<Node> nodes_;  // node, all of its left branch, all of its right one
};

}  // namespace tandem
