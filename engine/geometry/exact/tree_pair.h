#pragma once

#include <array>
#include <limits>
#include <utility>

#include "engine/geometry/exact/box_tree.h"

namespace tandem {

/// Calls `visit(leaf)` for the leaves whose boxes lie within the square root of `squared` of p, the
/// nearer ones first. `visit` returns the new `squared`.
template <typename Visit>
void VisitNearLeaves(const BoxTree& tree, const Vec3& p, double squared, const Visit& visit) {
  if (tree.nodes.empty()) return;
  struct Open {
    std::uint32_t node;
    double squared_distance;
  };
  std::array<Open, BoxTree::kMaxDepth + 1> stack;
  std::size_t depth = 0;
  stack[depth++] = {0, SquaredDistance(tree.nodes[0].box, p)};
  while (depth > 0) {
    const Open open = stack[--depth];
    if (open.squared_distance > squared) continue;
    const BoxTree::Node& node = tree.nodes[open.node];
    if (node.leaf()) {
      squared = visit(node);
      continue;
    }
    Open near{open.node + 1, SquaredDistance(tree.nodes[open.node + 1].box, p)};
    Open far{node.right, SquaredDistance(tree.nodes[node.right].box, p)};
    if (far.squared_distance < near.squared_distance) std::swap(near, far);
    stack[depth++] = far;
    stack[depth++] = near;
  }
}

/// Bounds the distance between points of two boxes from below. The first box is turned and moved by
/// X_BA, kept as a matrix, its absolute values and a shift.
struct RotatedFrame {
  explicit RotatedFrame(const Pose& X_BA)
      : R(X_BA.q.toRotationMatrix()), R_abs(R.cwiseAbs()), p(X_BA.p) {}

  double Least(const Bounds& box_A, const Bounds& box_B) const {
    const Vec3 half_A = 0.5 * box_A.size();
    const Vec3 half_B = 0.5 * box_B.size();
    const Vec3 apart = (R * box_A.centre() + p - box_B.centre()).cwiseAbs() - half_B;
    const double of_boxes = (apart - R_abs * half_A).cwiseMax(0.0).norm();
    const double of_ball = apart.cwiseMax(0.0).norm() - half_A.norm();
    return std::max(of_boxes, of_ball);
  }

  Mat3 R;
  Mat3 R_abs;
  Vec3 p;
};

/// Calls `visit(leaf_a, leaf_b)` for pairs of leaves, roughly the nearer ones first. `least(node_a,
/// node_b)` bounds a pair's distance from below. Pairs farther apart than `within()` are left out;
/// it is called before each pair, and a value below 0 ends the search. Returns a lower bound of the
/// distances left out (infinity: none).
template <typename Least, typename Within, typename Visit>
double VisitNearPairs(const BoxTree& a, const BoxTree& b, const Least& least, const Within& within,
                      const Visit& visit) {
  double left_out = std::numeric_limits<double>::infinity();
  if (a.nodes.empty() || b.nodes.empty()) return left_out;
  struct Open {
    std::uint32_t a, b;
    double least;
  };
  // each step down either tree leaves one pair behind
  std::array<Open, 2 * BoxTree::kMaxDepth + 2> stack;
  std::size_t depth = 0;
  stack[depth++] = {0, 0, least(a.nodes[0], b.nodes[0])};
  while (depth > 0) {
    const Open open = stack[--depth];
    if (open.least > within()) {
      left_out = std::min(left_out, open.least);
      continue;
    }
    const BoxTree::Node& node_a = a.nodes[open.a];
    const BoxTree::Node& node_b = b.nodes[open.b];
    if (node_a.leaf() && node_b.leaf()) {
      visit(node_a, node_b);
      continue;
    }
    const bool a_is_larger = node_a.box.size().squaredNorm() >= node_b.box.size().squaredNorm();
    Open near = open;
    Open far = open;
    if (!node_a.leaf() && (node_b.leaf() || a_is_larger)) {
      near.a = open.a + 1;
      far.a = node_a.right;
    } else {
      near.b = open.b + 1;
      far.b = node_b.right;
    }
    near.least = least(a.nodes[near.a], b.nodes[near.b]);
    far.least = least(a.nodes[far.a], b.nodes[far.b]);
    if (far.least < near.least) std::swap(near, far);
    stack[depth++] = far;
    stack[depth++] = near;
  }
  return left_out;
}

}  // namespace tandem
