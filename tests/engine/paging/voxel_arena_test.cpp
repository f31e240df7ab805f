#include "engine/paging/voxel_arena.h"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "engine/voxel/build/voxelize.h"
#include "tests/support/delayed_pages.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::DelayedPages;

Voxmap Ball(const VoxelizeOptions& options) {
  Result<Voxmap> made = Voxelize(testing::Sphere(0.5, 4), options);
  TANDEM_CHECK(made);
  return std::move(*made);
}

/// Counts the voxels of a record's hyperchunk that differ from those of the whole map, in any
/// field.
std::size_t Differences(const Voxmap& whole, const Voxmap& part, std::uint32_t record) {
  const auto& size = whole.header().size;
  std::size_t differences = 0;
  for (std::uint32_t c = 0; c < size[0] * size[1] * size[2]; ++c) {
    if (whole.index()[c] != record) continue;
    const GridIndex at{static_cast<std::int32_t>(c % size[0]),
                       static_cast<std::int32_t>(c / size[0] % size[1]),
                       static_cast<std::int32_t>(c / size[0] / size[1])};
    for (const Field field : kAllFields) {
      for (std::int32_t z = 0; z < kHyperchunkSide; ++z) {
        for (std::int32_t y = 0; y < kHyperchunkSide; ++y) {
          for (std::int32_t x = 0; x < kHyperchunkSide; ++x) {
            const GridIndex voxel = at * kHyperchunkSide + GridIndex{x, y, z};
            differences += whole.Value(field, voxel) != part.Value(field, voxel) ? 1U : 0U;
          }
        }
      }
    }
  }
  return differences;
}

TEST(VoxelArena, ReadsAsTheWholeMapAfterAnyHistory) {
  for (const auto& [range, bits] : {std::pair{1, 2}, {8, 4}, {16, 8}}) {
    const Voxmap whole = Ball({.voxel_size = 0.006, .range = range, .bits = bits});
    const DelayedPages pages(whole);
    std::vector<std::uint32_t> records;
    for (std::uint32_t r = 2; r < whole.header().record_count; ++r) {
      if (pages.HasPage(r)) records.push_back(r);
    }
    ASSERT_GT(records.size(), 20U);
    VoxelArena arena(pages.outline(), 4096);
    std::mt19937_64 random(7);
    std::vector<std::uint32_t> there;
    for (int step = 0; step < 60; ++step) {
      const std::uint32_t record = records[random() % records.size()];
      const auto found = std::find(there.begin(), there.end(), record);
      if (found != there.end()) {
        arena.Remove(record);
        there.erase(found);
        continue;
      }
      VoxelPage page;
      ASSERT_FALSE(pages.Read(record, page, {}));
      ASSERT_TRUE(arena.Put(record, page));
      there.push_back(record);
    }
    for (const std::uint32_t record : there) {
      EXPECT_EQ(Differences(whole, arena.voxmap(), record), 0U) << bits << " bits";
    }
    for (const std::uint32_t record : there) arena.Remove(record);
    EXPECT_EQ(arena.free_frames(), arena.frames());
  }
}

TEST(VoxelArena, ClassifiesChunksWithoutPages) {
  const Voxmap whole = Ball({.voxel_size = 0.006});
  const DelayedPages pages(whole);
  const VoxelArena arena(pages.outline(), 1);
  const auto& size = whole.header().size;
  const auto chunks = [&size](std::size_t axis) {
    return static_cast<std::int32_t>(8 * size[axis]);
  };
  for (std::int32_t z = 0; z < chunks(2); ++z) {
    for (std::int32_t y = 0; y < chunks(1); ++y) {
      for (std::int32_t x = 0; x < chunks(0); ++x) {
        ASSERT_EQ(arena.voxmap().ChunkValue({x, y, z}), whole.ChunkValue({x, y, z}));
      }
    }
  }
}

TEST(VoxelArena, RefusesPagesBeyondItsCapacity) {
  const Voxmap whole = Ball({.voxel_size = 0.006});
  const DelayedPages pages(whole);
  std::uint32_t record = 2;
  while (!pages.HasPage(record)) ++record;
  VoxelPage page;
  ASSERT_FALSE(pages.Read(record, page, {}));
  VoxelArena arena(pages.outline(), 1);
  EXPECT_FALSE(arena.Put(record, page));
  EXPECT_EQ(arena.free_frames(), 1U);
}

}  // namespace
}  // namespace tandem
