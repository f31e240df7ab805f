#include "engine/geometry/mesh/weld.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "engine/base/check.h"

namespace tandem {
namespace {

constexpr std::uint32_t kNoVertex = std::numeric_limits<std::uint32_t>::max();

std::uint64_t Mix(std::uint64_t x) {
  x ^= x >> 32U;
  x *= 0xd6e8feb86659fd93ULL;
  x ^= x >> 32U;
  x *= 0xd6e8feb86659fd93ULL;
  return x ^ (x >> 32U);
}

std::uint64_t HashOf(const FloatPoint& p) {
  std::uint64_t hash = 0;
  for (const float x : p) {
    // adding 0 gives -0 the bits of 0
    hash = Mix(hash + 0x9e3779b97f4a7c15ULL + std::bit_cast<std::uint32_t>(x + 0.0F));
  }
  return hash;
}

using Cell = std::array<double, 3>;  // whole numbers, of any size

struct CellHash {
  std::size_t operator()(const Cell& cell) const {
    std::uint64_t hash = 0;
    for (const double x : cell) {
      hash = Mix(hash + 0x9e3779b97f4a7c15ULL + std::bit_cast<std::uint64_t>(x + 0.0));
    }
    return hash;
  }
};

double SquaredDistance(const FloatPoint& a, const FloatPoint& b) {
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double d = double{a[k]} - double{b[k]};
    sum += d * d;
  }
  return sum;
}

/// Keeps the vertices found so far, by the cell of a grid as wide as the tolerance.
class VertexGrid {
 public:
  VertexGrid(std::span<const FloatPoint> points, double tolerance)
      : points_(points), tolerance_(tolerance) {}

  /// Returns the least vertex within the tolerance of `p`, or kNoVertex.
  std::uint32_t Find(const FloatPoint& p, const std::vector<std::uint32_t>& first_point) const {
    std::uint32_t found = kNoVertex;
    const Cell home = CellOf(p);
    for (unsigned n = 0; n < 27; ++n) {
      const Cell cell{home[0] + kSteps[n % 3], home[1] + kSteps[n / 3 % 3],
                      home[2] + kSteps[n / 9]};
      const auto at = cells_.find(cell);
      if (at == cells_.end()) continue;
      for (const std::uint32_t vertex : at->second) {
        if (vertex < found &&
            SquaredDistance(points_[first_point[vertex]], p) <= tolerance_ * tolerance_) {
          found = vertex;
        }
      }
    }
    return found;
  }
  void Add(const FloatPoint& p, std::uint32_t vertex) { cells_[CellOf(p)].push_back(vertex); }

 private:
  static constexpr std::array<double, 3> kSteps{-1, 0, 1};

  Cell CellOf(const FloatPoint& p) const {
    return {std::floor(double{p[0]} / tolerance_), std::floor(double{p[1]} / tolerance_),
            std::floor(double{p[2]} / tolerance_)};
  }

  std::span<const FloatPoint> points_;
  double tolerance_;
  std::unordered_map<Cell, std::vector<std::uint32_t>, CellHash> cells_;
};

}  // namespace

Weld WeldEqual(std::span<const FloatPoint> points) {
  TANDEM_CHECK(points.size() < kNoVertex);
  Weld weld;
  weld.vertex_of_point.resize(points.size());
  // open addressing, at most half full
  std::vector<std::uint32_t> slots(std::bit_ceil(2 * points.size() + 1), kNoVertex);
  const std::size_t mask = slots.size() - 1;
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::size_t slot = HashOf(points[i]) & mask;
    while (slots[slot] != kNoVertex && points[weld.first_point[slots[slot]]] != points[i]) {
      slot = (slot + 1) & mask;
    }
    if (slots[slot] == kNoVertex) {
      slots[slot] = static_cast<std::uint32_t>(weld.first_point.size());
      weld.first_point.push_back(static_cast<std::uint32_t>(i));
    }
    weld.vertex_of_point[i] = slots[slot];
  }
  return weld;
}

Weld WeldNear(std::span<const FloatPoint> points, double tolerance) {
  Weld equal = WeldEqual(points);
  double largest = 0;
  for (const FloatPoint& p : points) {
    for (const float x : p) largest = std::max(largest, std::abs(double{x}));
  }
  // a grid finer than the numbers themselves separates no more than equality does
  if (!(tolerance > 1e-15 * largest)) return equal;

  Weld weld;
  VertexGrid grid(points, tolerance);
  std::vector<std::uint32_t> vertex_of_equal(equal.first_point.size());
  for (std::size_t i = 0; i < equal.first_point.size(); ++i) {
    const std::uint32_t point = equal.first_point[i];
    std::uint32_t vertex = grid.Find(points[point], weld.first_point);
    if (vertex == kNoVertex) {
      vertex = static_cast<std::uint32_t>(weld.first_point.size());
      weld.first_point.push_back(point);
      grid.Add(points[point], vertex);
    }
    vertex_of_equal[i] = vertex;
  }
  weld.vertex_of_point.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    weld.vertex_of_point[i] = vertex_of_equal[equal.vertex_of_point[i]];
  }
  return weld;
}

}  // namespace tandem
