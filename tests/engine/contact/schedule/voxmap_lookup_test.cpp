#include "engine/contact/schedule/voxmap_lookup.h"

#include <algorithm>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "tests/engine/contact/schedule/random_map.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::EveryTarget;
using testing::kBlockVoxel;
using testing::RandomDirection;
using testing::RandomMap;
using testing::RandomRotation;
using testing::Uniform;

Pointshell RandomShell(std::mt19937_64& random, std::size_t chunks, double spread) {
  Pointshell shell;
  shell.spacing = kBlockVoxel;
  for (std::size_t c = 0; c < chunks; ++c) {
    Pointshell::Chunk chunk;
    chunk.first = static_cast<std::uint32_t>(shell.size());
    chunk.count = static_cast<std::uint32_t>(1 + random() % 40);
    const Vec3 centre = 0.8 * Vec3(Uniform(random, -1, 1), Uniform(random, -1, 1), 0);
    for (std::uint32_t i = 0; i < chunk.count; ++i) {
      const Vec3 p = centre + spread * RandomDirection(random);
      const Vec3 n = RandomDirection(random);
      shell.x.push_back(static_cast<float>(p.x()));
      shell.y.push_back(static_cast<float>(p.y()));
      shell.z.push_back(static_cast<float>(p.z()));
      shell.nx.push_back(static_cast<float>(n.x()));
      shell.ny.push_back(static_cast<float>(n.y()));
      shell.nz.push_back(static_cast<float>(n.z()));
      const auto label = static_cast<Label>(2 - 3 * i / chunk.count);
      shell.labels.push_back(label);
      ++chunk.labels[static_cast<std::size_t>(label)];
    }
    shell.chunks.push_back(chunk);
  }
  return shell;
}

/// Reads one point at a time, from the map's own look-up.
BlockReading ReadSingly(const PointBlocks& blocks, const VoxelTransform& transform,
                        const Voxmap& voxmap, int threshold, std::size_t b) {
  BlockReading reading{0, 255};
  for (std::size_t lane = 0; lane < blocks.block(b).count; ++lane) {
    const int mark = voxmap.Value(blocks.fields()[b], VoxelAt(transform(blocks, b, lane)));
    reading.nearest = std::min(reading.nearest, static_cast<std::uint8_t>(mark));
    if (mark <= threshold) reading.contacts |= static_cast<std::uint16_t>(1U << lane);
  }
  return reading;
}

using BlockTest = EveryTarget;

TEST_F(BlockTest, ReadsTheMapsValuesOnEveryInstructionSet) {
  std::mt19937_64 random(11);
  struct Kind {
    int bits, range;
  };
  for (const Kind kind : {Kind{2, 1}, Kind{4, 8}, Kind{4, 13}, Kind{8, 100}}) {
    const Voxmap voxmap = RandomMap(kind.bits, kind.range, random());
    for (const double spread : {0.5 * kBlockVoxel, 6 * kBlockVoxel, 60 * kBlockVoxel}) {
      const PointBlocks blocks(RandomShell(random, 60, spread));
      std::vector<std::uint32_t> list;
      for (std::uint32_t b = 0; b < blocks.size(); ++b) {
        if (random() % 3 != 0) list.push_back(b);
      }
      // into the map, across its border, far off
      for (const double away : {0.3, 1.5, 1e3, 1e9}) {
        const Pose X_VS{RandomRotation(random),
                        Vec3::Constant(0.9) + away * RandomDirection(random)};
        const double shift = random() % 2 == 0 ? 0 : Uniform(random, -1, 1) * kBlockVoxel;
        const VoxelTransform transform(X_VS, kBlockVoxel, shift);
        const int threshold = static_cast<int>(2 + random() % 4);
        ForEachTarget([&] {
          std::vector<BlockReading> readings(list.size());
          TestBlocks(blocks, transform, voxmap, threshold, list, readings.data());
          std::size_t wrong = 0;
          for (std::size_t k = 0; k < list.size(); ++k) {
            const BlockReading expected = ReadSingly(blocks, transform, voxmap, threshold, list[k]);
            wrong += readings[k].contacts != expected.contacts ||
                     readings[k].nearest != expected.nearest;
          }
          EXPECT_EQ(wrong, 0U) << "bits " << kind.bits << " spread " << spread << " away " << away;
        });
      }
    }
  }
}

TEST(VoxelTransform, ErrorStaysWithinItsBoundForLargeMaps) {
  std::mt19937_64 random(13);
  for (const double extent : {100.0, 3e3, 2e4, 2e5}) {
    const double reach = 0.3 * extent;  // voxels; size of the shell
    double worst = 0;
    for (int trial = 0; trial < 40; ++trial) {
      Pointshell shell = RandomShell(random, 20, 6 * kBlockVoxel);
      const double scale = reach * kBlockVoxel / 0.9;
      for (auto* axis : {&shell.x, &shell.y, &shell.z}) {
        for (float& p : *axis) p *= static_cast<float>(scale);
      }
      const PointBlocks blocks(shell);
      const Pose X_VS{
          RandomRotation(random),
          extent * kBlockVoxel * Vec3(Uniform(random, 0, 1), Uniform(random, 0, 1), 0.5)};
      const VoxelTransform transform(X_VS, kBlockVoxel, 0);
      for (std::size_t b = 0; b < blocks.size(); ++b) {
        for (std::size_t lane = 0; lane < blocks.block(b).count; ++lane) {
          const Vec3 exact = X_VS * shell.point(blocks.block(b).first + lane) / kBlockVoxel;
          const std::array<float, 3> p = transform(blocks, b, lane);
          worst = std::max(worst, (Vec3(p[0], p[1], p[2]) - exact).cwiseAbs().maxCoeff());
        }
      }
    }
    EXPECT_LT(worst, PlaceError(extent + reach)) << extent;
  }
}

// a conversion of such a place to an integer is undefined
TEST(VoxelAt, HugeCoordinatesAreOutsideEveryMap) {
  const float none = std::numeric_limits<float>::quiet_NaN();
  const GridIndex beyond = VoxelAt({1e30F, -1e30F, none});
  EXPECT_EQ(beyond.x, 1 << 30);
  EXPECT_EQ(beyond.y, -(1 << 30));
  EXPECT_EQ(beyond.z, -(1 << 30));
  const GridIndex near = VoxelAt({2.5F, -2.5F, -3.0F});
  EXPECT_EQ(near.x, 2);
  EXPECT_EQ(near.y, -3);
  EXPECT_EQ(near.z, -3);
}

TEST_F(BlockTest, EmptyListReadsNothing) {
  const Voxmap voxmap = RandomMap(4, 8, 1);
  std::mt19937_64 random(2);
  const PointBlocks blocks(RandomShell(random, 3, kBlockVoxel));
  BlockReading untouched{77, 77};
  TestBlocks(blocks, VoxelTransform(Pose{}, kBlockVoxel, 0), voxmap, 3, {}, &untouched);
  EXPECT_EQ(untouched.contacts, 77);
  EXPECT_EQ(untouched.nearest, 77);
}

}  // namespace
}  // namespace tandem
