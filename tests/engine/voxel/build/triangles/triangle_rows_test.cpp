#include "engine/voxel/build/triangles/triangle_rows.h"

#include <algorithm>
#include <random>
#include <tuple>

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "engine/voxel/build/triangles/triangle_batch.h"
#include "tests/support/triangle_overlap.h"

namespace tandem {
namespace {

constexpr std::int64_t kOne = std::int64_t{1} << kSnapBits;

/// Returns a triangle with corners anywhere, on grid planes, or on voxel centres: slivers,
/// segments, points, and triangles in planes along the axes.
SnappedTriangle RandomTriangle(std::mt19937_64& random) {
  const std::array<int, 3> reaches{2, 8, 40};
  const auto reach = static_cast<std::uint64_t>(reaches[random() % 3] * kOne);
  const std::uint64_t kind = random() % 7;
  SnappedTriangle t;
  for (SnappedPoint& p : t) {
    for (std::int64_t& c : p) {
      c = static_cast<std::int64_t>(random() % reach);
      if (kind == 1 || (kind == 2 && random() % 2 == 0)) c = c / kOne * kOne;
      if (kind == 3) c = c / (kOne / 2) * (kOne / 2);
    }
  }
  if (kind == 4) t[2] = t[1];
  const std::size_t k = random() % 3;
  if (kind == 5) t[1][k] = t[2][k] = t[0][k];
  if (kind == 6) {
    for (std::size_t i = 0; i < 3; ++i) t[2][i] = 2 * t[1][i] - t[0][i];
  }
  const std::int64_t shift = static_cast<std::int64_t>(random() % 300) * kOne - 150 * kOne;
  for (SnappedPoint& p : t) {
    for (std::int64_t& c : p) c += shift;
  }
  return t;
}

// The oracle is the separating-axis test in whole numbers, voxel by voxel.
TEST(TriangleRows, MatchTheSeparatingAxisTest) {
  std::mt19937_64 random(5);
  std::vector<std::uint64_t> rows(kBrickRows + TriangleRows::kPadding);
  long met_in_all = 0;
  for (int trial = 0; trial < 800; ++trial) {
    const SnappedTriangle t = RandomTriangle(random);
    const TriangleRows by_rows(t, kSnapBits);
    const testing::TriangleOverlap by_axes(t);
    const GridIndex lowest = by_rows.lowest() >> 6;
    const GridIndex highest = by_rows.highest() >> 6;
    for (int z = lowest.z; z <= highest.z; ++z) {
      for (int y = lowest.y; y <= highest.y; ++y) {
        for (int x = lowest.x; x <= highest.x; ++x) {
          const GridIndex place{x, y, z};
          std::fill(rows.begin(), rows.end(), 0);
          by_rows.Mark(place * kHyperchunkSide, rows.data(), 0, nullptr);
          for (std::size_t c = 0; c < kChunksPerHyperchunk; ++c) {
            const GridIndex chunk = BlockCell(c);
            std::array<std::uint64_t, 8> expected{};
            by_axes.MarkBlock(place * kChunkSide + chunk, kSnapBits, expected);
            std::array<std::uint64_t, 8> in_chunk{};
            by_rows.MarkChunk(place * kChunkSide + chunk, in_chunk);
            ASSERT_EQ(in_chunk, expected);
            for (std::size_t cell = 0; cell < kVoxelsPerChunk; ++cell) {
              const GridIndex i = chunk * kChunkSide + BlockCell(cell);
              const std::uint64_t row = rows[static_cast<std::size_t>(i.y + 64 * i.z)];
              const bool met = (row >> i.x & 1U) != 0;
              ASSERT_EQ(met, (expected[cell >> 6U] >> (cell & 63U) & 1U) != 0) << "trial " << trial;
              met_in_all += met;
            }
          }
        }
      }
    }
  }
  EXPECT_GT(met_in_all, 50000);
}

// A tetrahedron's rows of centres go in as often as out, whether corners lie on them or not.
TEST(TriangleRows, CrossingsOfClosedSurfacesCancelInEveryRow) {
  std::mt19937_64 random(6);
  long crossings_in_all = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    std::array<SnappedPoint, 4> p;
    for (SnappedPoint& corner : p) {
      for (std::int64_t& c : corner) {
        c = static_cast<std::int64_t>(random() % (50ULL << kSnapBits));
        if (trial % 2 == 0) c = c / (kOne / 2) * (kOne / 2);
      }
    }
    const std::array<std::array<std::size_t, 3>, 4> faces{
        {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
    std::vector<std::uint64_t> rows(kBrickRows + TriangleRows::kPadding, 0);
    std::vector<Crossing> crossings;
    for (const auto& [a, b, c] : faces) {
      TriangleRows({p[a], p[b], p[c]}, kSnapBits).Mark({0, 0, 0}, rows.data(), 1, &crossings);
    }
    std::vector<int> sums(kBrickRows, 0);
    for (const Crossing& c : crossings) sums[c.row] += c.entering;
    for (const int sum : sums) ASSERT_EQ(sum, 0) << "trial " << trial;
    crossings_in_all += static_cast<long>(crossings.size());
  }
  EXPECT_GT(crossings_in_all, 10000);
}

std::vector<std::tuple<int, int, int>> Sorted(const std::vector<Crossing>& crossings) {
  std::vector<std::tuple<int, int, int>> all;
  for (const Crossing& c : crossings) all.emplace_back(c.row, c.from, c.entering);
  std::sort(all.begin(), all.end());
  return all;
}

// The oracle is one triangle after another, which separating axes judge above.
TEST(TriangleBatch, MatchesSingleTrianglesOnEveryInstructionSet) {
  std::mt19937_64 random(7);
  const GridIndex first{64, -128, 0};
  std::size_t crossings_in_all = 0;
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<SnappedTriangle> triangles;
    std::vector<int> facing;
    for (std::size_t i = 0; i < 1 + random() % 100; ++i) {
      SnappedTriangle t = RandomTriangle(random);
      for (std::size_t k = 0; k < 3; ++k) {
        // into the block, over its sides, or past it
        const std::int64_t at = static_cast<std::int64_t>(random() % 100) - 20;
        const std::int64_t corner = std::array{first.x, first.y, first.z}[k];
        const std::int64_t lowest = std::min({t[0][k], t[1][k], t[2][k]}) >> kSnapBits;
        for (SnappedPoint& p : t) p[k] += (corner + at - lowest) * kOne;
      }
      triangles.push_back(t);
      facing.push_back(static_cast<int>(random() % 3) - 1);
    }
    std::vector<std::uint64_t> expected(kBrickRows + TriangleRows::kPadding, 0);
    std::vector<Crossing> expected_crossings;
    const std::vector<std::uint64_t> none = expected;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      TriangleRows(triangles[i], kSnapBits)
          .Mark(first, expected.data(), facing[i], &expected_crossings);
    }
    crossings_in_all += expected_crossings.size();
    for (std::int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1) {
      hwy::SetSupportedTargetsForTest(left & -left);
      std::vector<std::uint64_t> rows = none;
      std::vector<Crossing> crossings;
      TriangleBatch batch(first, rows.data(), &crossings);
      for (std::size_t i = 0; i < triangles.size(); ++i) {
        batch.Add(triangles[i][0], triangles[i][1], triangles[i][2], facing[i]);
      }
      batch.Finish();
      hwy::SetSupportedTargetsForTest(0);
      ASSERT_EQ(rows, expected) << "trial " << trial;
      ASSERT_EQ(Sorted(crossings), Sorted(expected_crossings)) << "trial " << trial;
    }
  }
  EXPECT_GT(crossings_in_all, 10000U);
}

}  // namespace
}  // namespace tandem
