#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/base/spatial.h"

namespace tandem {

/// A binary tree of axis-aligned boxes over items that the caller keeps, split by the surface-area
/// heuristic. Empty when there are no items.
struct BoxTree {
  struct Node {
    Bounds box;
    std::uint32_t first = 0;  // for a leaf: its items are order[first], order[first + 1], …
    std::uint32_t count = 0;  // number of a leaf's items; 0 in an inner node
    std::uint32_t right = 0;  // right child of an inner node; the left one is the next node
    bool leaf() const { return count > 0; }
  };

  static constexpr std::size_t kMaxDepth = 96;  // levels, for any number of items: sizes stacks

  std::vector<Node> nodes;  // the root first, parents before children
  std::vector<std::uint32_t> order;
};

BoxTree BuildBoxTree(const std::vector<Bounds>& items, std::uint32_t leaf_size);

/// Returns the squared distance from p to the box, 0 inside.
inline double SquaredDistance(const Bounds& box, const Vec3& p) {
  const Vec3 beyond = (box.min - p).cwiseMax(p - box.max).cwiseMax(Vec3::Zero());
  return beyond.squaredNorm();
}

}  // namespace tandem
