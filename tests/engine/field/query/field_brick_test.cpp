#include "engine/field/query/field_brick.h"

#include <cmath>

#include <gtest/gtest.h>

namespace tandem {
namespace {

std::array<float, kBrickNodes> Filled(float (*value)(float x, float y, float z)) {
  std::array<float, kBrickNodes> values;
  for (std::size_t node = 0; node < kBrickNodes; ++node) {
    values[node] = value(static_cast<float>(node % 5), static_cast<float>(node / 5 % 5),
                         static_cast<float>(node / 25));
  }
  return values;
}

float WorstOf(const PackedBrick& packed, const std::array<float, kBrickNodes>& values) {
  std::vector<std::uint8_t> steps = packed.steps;
  steps.resize(steps.size() + 3);
  float worst = 0;
  for (std::size_t node = 0; node < kBrickNodes; ++node) {
    const float kept = NodeValue(packed.brick, steps.data(), node % 5, node / 5 % 5, node / 25);
    worst = std::max(worst, std::abs(kept - values[node]));
  }
  return worst;
}

TEST(FieldBrick, StoresAPlaneWithoutResiduals) {
  const auto values = Filled([](float x, float y, float z) {
    return -2.5F + 0.6F * x - 0.48F * y + 0.64F * z;
  });
  const PackedBrick packed = PackBrick(values);
  EXPECT_TRUE(packed.steps.empty());
  EXPECT_LE(WorstOf(packed, values), 1.0F / 2048);
}

TEST(FieldBrick, StoresACurvedSurfaceInFewBits) {
  // a ball of 60 voxels: at most 0.1 off a plane
  const auto values = Filled([](float x, float y, float z) {
    return std::hypot(x + 30, y + 40, z + 33.17F) - 60;
  });
  const PackedBrick packed = PackBrick(values);
  EXPECT_LE(packed.brick.bits, 8);
  EXPECT_EQ(packed.steps.size(), (kBrickNodes * packed.brick.bits + 7) / 8);
  EXPECT_LE(WorstOf(packed, values), 0.5F * FieldBrick::kStep + 1e-6F);
}

TEST(FieldBrick, StoresAnEdgeInMoreBits) {
  const auto values = Filled([](float x, float y, float) {
    return std::max(x - 2.3F, y - 1.6F);
  });
  const PackedBrick packed = PackBrick(values);
  EXPECT_GT(packed.brick.bits, 8);
  EXPECT_LE(packed.brick.bits, FieldBrick::kMostBits);
  EXPECT_LE(WorstOf(packed, values), 0.5F * FieldBrick::kStep + 1e-6F);
}

TEST(FieldBrick, StoredExcessOfCellsWithListsIsATightUpperBound) {
  for (int k = 0; k <= 2000; ++k) {
    const float over = 1e-3F * static_cast<float>(k);
    FieldBrick brick;
    brick.SetOverOfLists(over);
    EXPECT_GE(brick.OverOfLists(), over);
    EXPECT_LE(std::sqrt(brick.OverOfLists()), std::sqrt(over) + 0.095F);
  }
}

}  // namespace
}  // namespace tandem
