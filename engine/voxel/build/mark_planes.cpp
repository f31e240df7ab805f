#include "engine/voxel/build/mark_planes.h"

#include <algorithm>
#include <array>
#include <bit>

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include "engine/base/check.h"

namespace tandem {

MarkPlanes::MarkPlanes(std::span<const SurfaceBricks> rounds, int range, int bits)
    : rounds_(rounds), range_(range), bits_(bits), growing_(std::make_unique<GrowingMarks>()) {
  TANDEM_CHECK(rounds.size() == Rounds(range));
  growing_->digits.count = bits == 8 ? 8 : 4;
}

void MarkPlanes::Begin(const GridIndex& place) {
  place_ = place;
  record_ = {};
  planes_.clear();
  plane_count_ = 0;
  band_voxels_ = 0;
}

/// Sets the cube to the sources in and round the hyperchunk, as far as `range` voxels. Returns
/// whether there are any that may grow within it.
bool MarkPlanes::Gather(const SurfaceBricks& bricks, Field field, int range) {
  GrowingMarks& s = *growing_;
  s.octets.fill(0);
  std::array<const SurfaceBricks::Source*, 27> near{};
  bool any = false;
  for (std::int32_t n = 0; n < 27; ++n) {
    const GridIndex offset{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
    const SurfaceBricks::Brick* brick = bricks.At(place_ + offset);
    if (brick == nullptr) continue;
    const SurfaceBricks::Source& source = brick->sources[static_cast<std::size_t>(field)];
    if (source.empty()) continue;
    near[static_cast<std::size_t>(n)] = &source;
    any = true;
  }
  if (!any || (near[13] != nullptr && near[13]->full())) return false;
  any = false;
  // whole octets, though some of their rows are out of reach
  const int reach = (range + 7) / 8 * 8;
  for (int z = -range; z < kHyperchunkSide + range; ++z) {
    const auto layer = static_cast<std::size_t>(z + kHalo);
    const int bz = (z >> 6) + 1;
    unsigned occupied = 0;
    for (int n = 9 * bz; n < 9 * bz + 9; ++n) {
      const SurfaceBricks::Source* source = near[static_cast<std::size_t>(n)];
      if (source != nullptr) occupied |= source->octets[static_cast<std::size_t>(z & 63)];
    }
    if (occupied == 0) continue;
    for (int y = -reach; y < kHyperchunkSide + reach; y += 8) {
      const int by = (y >> 6) + 1;
      const auto* const* row_of_three = &near[static_cast<std::size_t>(3 * by + 9 * bz)];
      std::array<const std::uint64_t*, 3> rows{};
      bool some = false;
      for (std::size_t k = 0; k < 3; ++k) {
        if (row_of_three[k] == nullptr) continue;
        rows[k] = row_of_three[k]->Octet(static_cast<std::size_t>(z & 63),
                                         static_cast<std::size_t>((y & 63) / 8));
        some = some || rows[k] != nullptr;
      }
      if (!some) continue;
      const int octet = (y + kHalo) / 8;
      const auto row = static_cast<std::size_t>(GrowingMarks::kFirstRow + 8 * octet);
      std::uint64_t filled = 0;
      for (std::size_t i = 0; i < 8; ++i) {
        const std::uint64_t left = rows[0] != nullptr ? rows[0][i] : 0;
        const std::uint64_t here = rows[1] != nullptr ? rows[1][i] : 0;
        const std::uint64_t right = rows[2] != nullptr ? rows[2][i] : 0;
        const std::uint64_t low = left >> 48U | here << 16U;
        const std::uint64_t high = here >> 16U | right << 48U;
        s.cube[layer].words[0][row + i] = low;
        s.cube[layer].words[1][row + i] = high;
        filled |= low | high;
      }
      if (filled == 0) continue;
      any = true;
      s.octets[layer] = static_cast<std::uint16_t>(s.octets[layer] | 1U << octet);
    }
  }
  return any;
}

void MarkPlanes::ClearCube() {
  GrowingMarks& s = *growing_;
  for (std::size_t z = 0; z < GrowingMarks::kSide; ++z) {
    for (unsigned rest = s.touched[z]; rest != 0; rest &= rest - 1) {
      const auto row =
          static_cast<std::size_t>(GrowingMarks::kFirstRow + 8 * std::countr_zero(rest));
      for (auto& word : s.cube[z].words) std::fill_n(&word[row], 8, 0);
    }
  }
}

bool MarkPlanes::Grown(Field field, std::uint64_t* rows) {
  GrowingMarks& s = *growing_;
  if (!Gather(rounds_.back(), field, kHalo)) return false;
  s.digits.written.fill(0);
  GrowMarks(s, 0, kHalo);
  for (std::size_t z = 0; z < kHyperchunkSide; ++z) {
    for (std::size_t y = 0; y < kHyperchunkSide; ++y) {
      const auto& words = s.cube[z + kHalo].words;
      const std::size_t row = GrowingMarks::kFirstRow + kHalo + y;
      rows[y + kHyperchunkSide * z] = (words[0][row] >> 16U & 0xffffffffU) |
                                      (words[1][row] << 16U & ~std::uint64_t{0xffffffffU});
    }
  }
  ClearCube();
  return true;
}

void MarkPlanes::Add(Field field, const std::uint64_t* inside, bool solid) {
  GrowingMarks& s = *growing_;
  s.digits.written.fill(0);
  for (std::size_t round = 0; round < rounds_.size(); ++round) {
    const int base = static_cast<int>(round) * kHalo;
    const int range = std::min(kHalo, range_ - base);
    if (!Gather(rounds_[round], field, range)) continue;
    GrowMarks(s, base, range);
    ClearCube();
  }
  if (field == Field::kSurface) {
    CountMarks(s);
    band_voxels_ = s.marked;
  }
  const auto f = static_cast<std::size_t>(field);
  const SurfaceBricks::Brick* brick = rounds_.front().At(place_);
  const std::size_t plane_bytes = kVoxelsPerChunk / 8 * static_cast<std::size_t>(bits_);
  const SurfaceBricks::Source* surface =
      brick != nullptr && !brick->sources[0].empty() ? &brick->sources[0] : nullptr;
  alignas(64) ChunkDigits chunks;
  for (std::size_t cz = 0; cz < 8; ++cz) {
    VoxmapSlice& slice = record_.slices[f][cz];
    slice.first_plane = plane_count_;
    for (std::size_t cy = 0; cy < 8; ++cy) {
      bool any = false;
      for (std::size_t z = 8 * cz; z < 8 * cz + 8; ++z)
        any |= (s.digits.written[z] >> cy & 1U) != 0;
      if (!any && inside == nullptr && !solid) continue;
      const unsigned kinds = GatherChunks(s.digits, cy, cz, inside, surface, solid, chunks);
      record_.solid[cz] |= std::uint64_t{kinds >> 8U} << (8 * cy);
      slice.stored |= std::uint64_t{kinds & 0xffU} << (8 * cy);
      for (unsigned rest = kinds & 0xffU; rest != 0; rest &= rest - 1) {
        const auto& digits = chunks[static_cast<std::size_t>(std::countr_zero(rest))];
        ++plane_count_;
        planes_.resize(planes_.size() + plane_bytes);
        std::uint8_t* plane = &planes_[planes_.size() - plane_bytes];
        PackMarks(digits.data(), bits_, plane);
      }
    }
  }
}

SurfaceBricks GrownSources(const SurfaceBricks& bricks) {
  const HyperchunkBox& box = bricks.box();
  std::vector<SurfaceBricks::Brick> grown(box.cells());
  struct Scratch {
    std::unique_ptr<MarkPlanes> planes;
    SurfaceBricks::Packer packer;
    std::vector<std::uint64_t> rows = std::vector<std::uint64_t>(kBrickRows, 0);
  };
  tbb::enumerable_thread_specific<Scratch> scratch;
  tbb::parallel_for(std::size_t{0}, box.cells(), [&](std::size_t cell) {
    Scratch& mine = scratch.local();
    if (mine.planes == nullptr) {
      mine.planes = std::make_unique<MarkPlanes>(std::span(&bricks, 1), MarkPlanes::kHalo, 8);
    }
    SurfaceBricks::Brick& brick = grown[cell];
    brick.place = box.PlaceOf(cell);
    mine.planes->Begin(brick.place);
    const SurfaceBricks::Brick* before = bricks.At(brick.place);
    for (const Field field : kAllFields) {
      const auto f = static_cast<std::size_t>(field);
      if (before != nullptr && before->sources[f].full()) {
        mine.packer.TakeFull(field);
      } else if (mine.planes->Grown(field, mine.rows.data())) {
        mine.packer.Take(field, mine.rows.data());
      }
    }
    mine.packer.Fill(brick);
  });
  return SurfaceBricks(box, std::move(grown));
}

}  // namespace tandem
