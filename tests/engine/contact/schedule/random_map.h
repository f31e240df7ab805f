#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "engine/contact/schedule/voxmap_lookup.h"
#include "engine/voxel/build/voxmap_builder.h"
#include "engine/voxel/map/voxmap.h"

namespace tandem::testing {

constexpr double kBlockVoxel = 0.01;

/// Gives a chunk its marks in a field, as the image stores them.
inline void AddChunk(Field field, std::size_t chunk, const std::array<int, kVoxelsPerChunk>& marks,
                     int bits, VoxmapRecord& record, std::vector<std::uint8_t>& planes) {
  const std::size_t plane_bytes = kVoxelsPerChunk / 8 * static_cast<std::size_t>(bits);
  VoxmapSlice& slice = record.slices[static_cast<std::size_t>(field)][chunk / 64];
  const auto planes_before = static_cast<std::uint32_t>(planes.size() / plane_bytes);
  if (chunk % 64 == 0) slice.first_plane = planes_before;
  if (std::all_of(marks.begin(), marks.end(), [](int mark) {
        return mark == 0;
      }))
    return;
  const std::uint64_t bit = std::uint64_t{1} << (chunk % 64);
  if (std::all_of(marks.begin(), marks.end(), [](int mark) {
        return mark == kInteriorMark;
      })) {
    record.solid[chunk / 64] |= bit;
    return;
  }
  slice.stored |= bit;
  planes.resize(planes.size() + plane_bytes, 0);
  std::uint8_t* plane = &planes[planes.size() - plane_bytes];
  for (std::size_t cell = 0; cell < marks.size(); ++cell) {
    const std::size_t place = kVoxelsPerQuarter * QuarterOf(cell) + CellInQuarter(cell);
    const std::size_t at = place * static_cast<std::size_t>(bits);
    plane[at / 8] = static_cast<std::uint8_t>(plane[at / 8] | marks[cell] << (at % 8));
  }
}

/// Returns a map with a random mark in every voxel of some hyperchunks, so that no two neighbours
/// agree.
inline Voxmap RandomMap(int bits, int range, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const HyperchunkBox box{{-2, -1, -2}, {5, 4, 4}};
  const std::array<GridIndex, 3> places{GridIndex{-1, 0, 0}, GridIndex{0, 0, 0},
                                        GridIndex{0, 1, -1}};
  std::vector<VoxmapBuilder::Kind> kinds(box.cells(), VoxmapBuilder::Kind::kFar);
  for (const GridIndex& place : places) {
    kinds[box.CellOf(place)] = VoxmapBuilder::Kind::kMarked;
  }
  kinds[box.CellOf({1, 0, 0})] = VoxmapBuilder::Kind::kSolid;
  VoxmapBuilder builder(kBlockVoxel, range, bits, box, kinds);
  for (const GridIndex& place : places) {
    VoxmapRecord record;
    std::vector<std::uint8_t> planes;
    for (const Field field : kAllFields) {
      const int least = field == Field::kSurface ? 1 : 2;
      for (std::size_t chunk = 0; chunk < kChunksPerHyperchunk; ++chunk) {
        const bool empty = chunk % 4 == 1 && chunk / 64 < 3;
        std::array<int, kVoxelsPerChunk> marks{};
        for (int& mark : marks) {
          const int any = least + static_cast<int>(random() % static_cast<unsigned>(range + 2));
          mark = empty ? 0 : std::min(any, range + 2);
        }
        AddChunk(field, chunk, marks, bits, record, planes);
      }
    }
    builder.Add(place, record, planes);
  }
  return builder.Finish(0);
}

/// Runs a check with each instruction set that this machine has and a kernel is compiled for.
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

}  // namespace tandem::testing
