#include "engine/field/query/field_brick.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include <Eigen/Dense>

namespace tandem {

namespace {

template <typename Visit>
void VisitNodes(const Visit& visit) {
  for (std::size_t z = 0; z < kBrickSide; ++z) {
    for (std::size_t y = 0; y < kBrickSide; ++y) {
      for (std::size_t x = 0; x < kBrickSide; ++x) visit(x, y, z, NodeInBrick(x, y, z));
    }
  }
}

/// Distance from the surface beyond which a node counts for little, voxels: no place near the
/// surface reads it.
constexpr float kNear = 2.25F;

/// Sets the plane. `at_middle` is its value at the brick's middle.
void SetPlane(const Vec3& slopes, double at_middle, FieldBrick& brick) {
  double at_lowest = at_middle;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double slope = slopes[static_cast<Eigen::Index>(axis)] / FieldBrick::kSlope;
    brick.slopes[axis] =
        static_cast<std::int16_t>(std::lround(std::clamp(slope, -32767.0, 32767.0)));
    at_lowest -= 2.0 * brick.slopes[axis] * FieldBrick::kSlope;
  }
  brick.mean = static_cast<float>(at_lowest);
}

void FitPlane(std::span<const float, kBrickNodes> values, FieldBrick& brick) {
  const auto weight = [&](std::size_t node) {
    return std::abs(values[node]) <= kNear ? 1.0 : 1e-3;
  };
  // normal equations of least squares for the value at the middle and three slopes
  Eigen::Matrix4d squares = Eigen::Matrix4d::Zero();
  Eigen::Vector4d moments = Eigen::Vector4d::Zero();
  VisitNodes([&](std::size_t x, std::size_t y, std::size_t z, std::size_t node) {
    const Eigen::Vector4d row(1, static_cast<double>(x) - 2, static_cast<double>(y) - 2,
                              static_cast<double>(z) - 2);
    squares += weight(node) * row * row.transpose();
    moments += weight(node) * values[node] * row;
  });
  const Eigen::Vector4d plane = squares.ldlt().solve(moments);
  SetPlane(plane.tail<3>(), plane[0], brick);
}

}  // namespace

PackedBrick PackBrick(std::span<const float, kBrickNodes> values) {
  PackedBrick packed;
  FieldBrick& brick = packed.brick;
  FitPlane(values, brick);
  std::array<float, kBrickNodes> residuals;
  float farthest = 0;
  VisitNodes([&](std::size_t x, std::size_t y, std::size_t z, std::size_t node) {
    residuals[node] = values[node] - brick.Plane(static_cast<float>(x), static_cast<float>(y),
                                                 static_cast<float>(z));
    farthest = std::max(farthest, std::abs(residuals[node]));
  });
  constexpr long kMost = (1 << (FieldBrick::kMostBits - 1)) - 1;
  if (farthest > kMost * FieldBrick::kStep) brick.flags |= FieldBrick::kLargeSteps;
  std::array<std::int32_t, kBrickNodes> counts;
  std::int32_t most = 0;
  for (std::size_t node = 0; node < kBrickNodes; ++node) {
    const long count = std::lround(residuals[node] / brick.Step());
    counts[node] = static_cast<std::int32_t>(std::clamp(count, -kMost, kMost));
    most = std::max(most, std::abs(counts[node]));
  }
  if (most == 0) return packed;
  // a sign and the count
  brick.bits = static_cast<unsigned>(1 + std::bit_width(static_cast<std::uint32_t>(most))) & 15U;
  packed.steps.resize((kBrickNodes * brick.bits + 7) / 8 + 3);
  for (std::size_t node = 0; node < kBrickNodes; ++node) {
    const std::size_t bit = node * std::size_t{brick.bits};
    std::uint32_t word;
    std::memcpy(&word, &packed.steps[bit / 8], sizeof word);
    const std::uint32_t mask = (1U << brick.bits) - 1;
    word |= (static_cast<std::uint32_t>(counts[node]) & mask) << bit % 8;
    std::memcpy(&packed.steps[bit / 8], &word, sizeof word);
  }
  // the pool has bytes after its last brick
  packed.steps.resize((kBrickNodes * brick.bits + 7) / 8);
  return packed;
}

FieldBrick FlatBrick(const Vec3& nhat, double at_lowest) {
  FieldBrick brick;
  SetPlane(nhat, at_lowest + 2.0 * nhat.sum(), brick);
  return brick;
}

float NodeValue(const FieldBrick& brick, const std::uint8_t* steps, std::size_t x, std::size_t y,
                std::size_t z) {
  const float plane =
      brick.Plane(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
  if (brick.bits == 0) return plane;
  const std::size_t bit = NodeInBrick(x, y, z) * std::size_t{brick.bits};
  std::uint32_t word;
  std::memcpy(&word, steps + bit / 8, sizeof word);
  const auto high = static_cast<std::int32_t>(word << (32U - brick.bits - bit % 8));
  return plane + brick.Step() * static_cast<float>(high >> (32 - brick.bits));
}

}  // namespace tandem
