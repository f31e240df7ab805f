#include "engine/contact/block_test.h"

#include <random>

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::RandomDirection;
using testing::RandomRotation;
using testing::Uniform;

constexpr double kVoxel = 0.01;

/// A map with a random mark in every voxel of some hyperchunks, so that no two neighbours agree.
Voxmap RandomMap(int bits, int range, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  VoxmapBuilder builder(kVoxel, range, bits);
  for (const GridIndex& place : {GridIndex{-1, 0, 0}, GridIndex{0, 0, 0}, GridIndex{0, 1, -1}}) {
    HyperchunkMarks hyperchunk{.place = place, .marks = {}, .solid = false};
    for (const Field field : kAllFields) {
      std::vector<Mark>& marks = hyperchunk.marks[static_cast<std::size_t>(field)];
      marks.resize(std::size_t{1} << 18U);
      const int least = field == Field::kSurface ? 1 : 2;
      for (std::size_t i = 0; i < marks.size(); ++i) {
        // whole chunks without marks, and some solid ones
        const bool empty = (i >> 3 & 3) == 1 && (i >> 9 & 7) < 3;
        const int mark = least + static_cast<int>(random() % static_cast<unsigned>(range + 2));
        marks[i] = static_cast<Mark>(empty ? 0 : std::min(mark, range + 2));
      }
    }
    builder.Add(hyperchunk);
  }
  builder.Add({.place = {1, 0, 0}, .marks = {}, .solid = true});
  return builder.Finish();
}

Pointshell RandomShell(std::mt19937_64& random, std::size_t chunks, double spread) {
  Pointshell shell;
  shell.spacing = kVoxel;
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

/// One point at a time, from the map's own look-up.
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

class EveryTarget : public ::testing::Test {
 protected:
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }

  template <class Check>
  void ForEachTarget(const Check& check) {
    const std::int64_t supported = hwy::SupportedTargets();
    int targets = 0;
    for (std::int64_t left = supported; left != 0; left &= left - 1) {
      const std::int64_t target = left & -left;
      hwy::SetSupportedTargetsForTest(target);
      if (std::string(KernelIsa()) != hwy::TargetName(target)) continue;  // not compiled for it
      SCOPED_TRACE(hwy::TargetName(target));
      check();
      ++targets;
    }
    hwy::SetSupportedTargetsForTest(0);
    EXPECT_GE(targets, 2);
  }
};

using BlockTest = EveryTarget;

TEST_F(BlockTest, ReadsWhatTheMapSaysOnEveryInstructionSet) {
  std::mt19937_64 random(11);
  struct Kind {
    int bits, range;
  };
  for (const Kind kind : {Kind{2, 1}, Kind{4, 8}, Kind{4, 13}, Kind{8, 100}}) {
    const Voxmap voxmap = RandomMap(kind.bits, kind.range, random());
    for (const double spread : {0.5 * kVoxel, 6 * kVoxel, 60 * kVoxel}) {
      const PointBlocks blocks(RandomShell(random, 60, spread));
      std::vector<std::uint32_t> list;
      for (std::uint32_t b = 0; b < blocks.size(); ++b) {
        if (random() % 3 != 0) list.push_back(b);
      }
      // into the map, across its border, far off
      for (const double away : {0.3, 1.5, 1e3, 1e9}) {
        const Pose X_VS{RandomRotation(random),
                        Vec3::Constant(0.9) + away * RandomDirection(random)};
        const double shift = random() % 2 == 0 ? 0 : Uniform(random, -1, 1) * kVoxel;
        const VoxelTransform transform(X_VS, kVoxel, shift);
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

TEST_F(BlockTest, AnEmptyListReadsNothing) {
  const Voxmap voxmap = RandomMap(4, 8, 1);
  std::mt19937_64 random(2);
  const PointBlocks blocks(RandomShell(random, 3, kVoxel));
  BlockReading untouched{77, 77};
  TestBlocks(blocks, VoxelTransform(Pose{}, kVoxel, 0), voxmap, 3, {}, &untouched);
  EXPECT_EQ(untouched.contacts, 77);
  EXPECT_EQ(untouched.nearest, 77);
}

}  // namespace
}  // namespace tandem
