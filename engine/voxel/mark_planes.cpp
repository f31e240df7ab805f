#include "engine/voxel/mark_planes.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include "engine/base/check.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/voxel/mark_planes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Scratch = MarkPlanes::Scratch;
using Layer = MarkPlanes::Layer;
using W = hn::CappedTag<std::uint64_t, 8>;
using Words = hn::Vec<W>;
constexpr std::size_t kPart = hn::MaxLanes(W());  // rows of a vector

constexpr int kHalo = MarkPlanes::kHalo;
constexpr int kSide = MarkPlanes::kSide;
constexpr int kOctets = kSide / 8;

std::size_t RowOf(int octet) {
  return static_cast<std::size_t>(MarkPlanes::kFirstRow + 8 * octet);
}

/// Returns the octets that bits of `octets` may have reached after `steps` steps.
unsigned Spread(unsigned octets, int steps) {
  for (int reached = 0; reached < steps; reached += 8) {
    octets |= octets << 1U | octets >> 1U;
  }
  return octets & ((1U << kOctets) - 1);
}

using Octets = std::array<std::uint16_t, kSide>;  // per layer

/// Returns the octets of each layer and of those next to it.
Octets WithNeighbours(const Octets& octets) {
  Octets wider = octets;
  for (std::size_t z = 0; z < kSide; ++z) {
    if (z > 0) wider[z] = static_cast<std::uint16_t>(wider[z] | octets[z - 1]);
    if (z + 1 < kSide) wider[z] = static_cast<std::uint16_t>(wider[z] | octets[z + 1]);
  }
  return wider;
}

void GrowInLayer(const Layer& layer, int octet, Layer& grown) {
  const W w;
  const std::size_t row = RowOf(octet);
  for (std::size_t word = 0; word < 2; ++word) {
    const std::uint64_t* from = layer.words[word].data() + row;
    std::uint64_t* to = grown.words[word].data() + row;
    for (std::size_t i = 0; i < 8; i += kPart) {
      const Words here =
          hn::Or3(hn::LoadU(w, from + i - 1), hn::Load(w, from + i), hn::LoadU(w, from + i + 1));
      hn::Store(hn::Or3(here, hn::ShiftLeft<1>(here), hn::ShiftRight<1>(here)), w, to + i);
    }
  }
}

void ClearOctet(int octet, Layer& layer) {
  const W w;
  for (auto& word : layer.words) {
    for (std::size_t i = 0; i < 8; i += kPart) hn::Store(hn::Zero(w), w, &word[RowOf(octet) + i]);
  }
}

/// Flips the digits of `changed` for the voxels of an octet of a layer that are in the cube.
void Turn(const Layer& layer, int z, int octet, unsigned changed, Scratch& s) {
  const W w;
  const std::size_t row = RowOf(octet);
  const auto out =
      static_cast<std::size_t>(8 * (octet - kHalo / 8) + kHyperchunkSide * (z - kHalo));
  const Words low_half = hn::Set(w, 0xffffffffU);
  for (std::size_t i = 0; i < 8; i += kPart) {
    const Words low = hn::ShiftRight<16>(hn::Load(w, &layer.words[0][row + i]));
    const Words high = hn::ShiftLeft<16>(hn::Load(w, &layer.words[1][row + i]));
    const Words middle = hn::Or(hn::And(low, low_half), hn::AndNot(low_half, high));
    for (unsigned rest = changed; rest != 0; rest &= rest - 1) {
      std::uint64_t* to = &s.digits.rows[static_cast<std::size_t>(std::countr_zero(rest))][out + i];
      hn::Store(hn::Xor(hn::Load(w, to), middle), w, to);
    }
  }
}

/// Grows the cube of sources, which are `base` voxels from those of the field, by `range` voxels,
/// and writes the digits of the new voxels.
void Grow(Scratch& s, int base, int range) {
  const auto mark_at = [base, range](int distance) {
    const bool marked = distance <= range && (distance > 0 || base == 0);
    return marked ? static_cast<unsigned>(kSurfaceMark + base + distance) : 0U;
  };
  constexpr unsigned kMiddle = 0xffU << (kHalo / 8);
  const auto is_middle = [](int z) {
    return z >= kHalo && z < kHalo + kHyperchunkSide;
  };
  // by layer, octets of sources at most as many layers away as steps are done
  Octets octets = s.octets;
  Octets reached = octets;
  for (int step = 0; step < range; ++step) reached = WithNeighbours(reached);
  for (std::size_t z = 0; z < kSide; ++z) {
    s.touched[z] = static_cast<std::uint16_t>(Spread(reached[z], range));
  }
  for (int z = 0; z < kHyperchunkSide; ++z) {
    const auto layer = static_cast<std::size_t>(z);
    const unsigned touched =
        (Spread(reached[layer + kHalo], range) & kMiddle) >> static_cast<unsigned>(kHalo / 8);
    std::uint8_t& written = s.digits.written[layer];
    for (unsigned rest = touched & ~unsigned{written}; rest != 0; rest &= rest - 1) {
      const auto row = static_cast<std::size_t>(8 * std::countr_zero(rest) + kHyperchunkSide * z);
      for (std::size_t d = 0; d < s.digits.count; ++d) std::memset(&s.digits.rows[d][row], 0, 64);
    }
    written = static_cast<std::uint8_t>(written | touched);
  }
  for (int z = kHalo; z < kHalo + kHyperchunkSide; ++z) {
    for (unsigned rest = octets[static_cast<std::size_t>(z)] & kMiddle; rest != 0;
         rest &= rest - 1) {
      Turn(s.cube[static_cast<std::size_t>(z)], z, std::countr_zero(rest), mark_at(0) ^ mark_at(1),
           s);
    }
  }
  for (int step = 1; step <= range; ++step) {
    // the part that can still reach the hyperchunk
    const int reach = range - step;
    const int z0 = kHalo - reach;
    const int z1 = kHalo + kHyperchunkSide - 1 + reach;
    const int octet0 = (kHalo - reach) / 8;
    const int octet1 = (kHalo + kHyperchunkSide - 1 + reach) / 8;
    const unsigned wanted = (2U << octet1) - (1U << octet0);
    const unsigned changed = mark_at(step) ^ mark_at(step + 1);
    for (int z = z0 - 1; z <= z1 + 1; ++z) {
      // along x and y, one layer ahead of along z
      if (z >= 0 && z < kSide) {
        const auto layer = static_cast<std::size_t>(z);
        Layer& ring = s.ring[layer % 3];
        std::uint16_t& ring_octets = s.ring_octets[layer % 3];
        const unsigned grown = Spread(octets[layer], step) & wanted;
        for (unsigned rest = ring_octets & ~grown; rest != 0; rest &= rest - 1) {
          ClearOctet(std::countr_zero(rest), ring);
        }
        for (unsigned rest = grown; rest != 0; rest &= rest - 1) {
          GrowInLayer(s.cube[layer], std::countr_zero(rest), ring);
        }
        ring_octets = static_cast<std::uint16_t>(grown);
      }
      const int target = z - 1;
      if (target < z0 || target > z1) continue;
      const auto layer = static_cast<std::size_t>(target);
      const unsigned met = s.ring_octets[0] | s.ring_octets[1] | s.ring_octets[2];
      const W w;
      for (unsigned rest = met; rest != 0; rest &= rest - 1) {
        const int octet = std::countr_zero(rest);
        const std::size_t row = RowOf(octet);
        for (std::size_t word = 0; word < 2; ++word) {
          for (std::size_t i = row; i < row + 8; i += kPart) {
            hn::Store(hn::Or3(hn::Load(w, &s.ring[0].words[word][i]),
                              hn::Load(w, &s.ring[1].words[word][i]),
                              hn::Load(w, &s.ring[2].words[word][i])),
                      w, &s.cube[layer].words[word][i]);
          }
        }
        if (is_middle(target) && (kMiddle >> octet & 1U) != 0 && changed != 0) {
          Turn(s.cube[layer], target, octet, changed, s);
        }
      }
    }
    octets = WithNeighbours(octets);
  }
}

/// Counts the voxels of the hyperchunk that have a mark.
void CountMarked(Scratch& s) {
  const W w;
  auto count = hn::Zero(w);
  for (std::size_t z = 0; z < kHyperchunkSide; ++z) {
    for (unsigned rest = s.digits.written[z]; rest != 0; rest &= rest - 1) {
      const std::size_t row =
          8 * static_cast<std::size_t>(std::countr_zero(rest)) + kHyperchunkSide * z;
      for (std::size_t i = row; i < row + 8; i += kPart) {
        Words any = hn::Zero(w);
        for (std::size_t d = 0; d < s.digits.count; ++d) {
          any = hn::Or(any, hn::Load(w, &s.digits.rows[d][i]));
        }
        count = hn::Add(count, hn::PopulationCount(any));
      }
    }
  }
  s.marked = hn::GetLane(hn::SumOfLanes(w, count));
}

}  // namespace
}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace tandem {

namespace {

HWY_EXPORT(CountMarked);
HWY_EXPORT(Grow);

}  // namespace

MarkPlanes::MarkPlanes(std::span<const SurfaceBricks> rounds, int range, int bits)
    : rounds_(rounds), range_(range), bits_(bits), scratch_(std::make_unique<Scratch>()) {
  TANDEM_CHECK(rounds.size() == Rounds(range));
  scratch_->digits.count = bits == 8 ? 8 : 4;
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
  Scratch& s = *scratch_;
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
      const auto row = static_cast<std::size_t>(kFirstRow + 8 * octet);
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
  Scratch& s = *scratch_;
  for (std::size_t z = 0; z < kSide; ++z) {
    for (unsigned rest = s.touched[z]; rest != 0; rest &= rest - 1) {
      const auto row = static_cast<std::size_t>(kFirstRow + 8 * std::countr_zero(rest));
      for (auto& word : s.cube[z].words) std::fill_n(&word[row], 8, 0);
    }
  }
}

bool MarkPlanes::Grown(Field field, std::uint64_t* rows) {
  Scratch& s = *scratch_;
  if (!Gather(rounds_.back(), field, kHalo)) return false;
  s.digits.written.fill(0);
  HWY_DYNAMIC_DISPATCH(Grow)(s, 0, kHalo);
  for (std::size_t z = 0; z < kHyperchunkSide; ++z) {
    for (std::size_t y = 0; y < kHyperchunkSide; ++y) {
      const auto& words = s.cube[z + kHalo].words;
      const std::size_t row = kFirstRow + kHalo + y;
      rows[y + kHyperchunkSide * z] = (words[0][row] >> 16U & 0xffffffffU) |
                                      (words[1][row] << 16U & ~std::uint64_t{0xffffffffU});
    }
  }
  ClearCube();
  return true;
}

void MarkPlanes::Add(Field field, const std::uint64_t* inside, bool solid) {
  Scratch& s = *scratch_;
  s.digits.written.fill(0);
  for (std::size_t round = 0; round < rounds_.size(); ++round) {
    const int base = static_cast<int>(round) * kHalo;
    const int range = std::min(kHalo, range_ - base);
    if (!Gather(rounds_[round], field, range)) continue;
    HWY_DYNAMIC_DISPATCH(Grow)(s, base, range);
    ClearCube();
  }
  if (field == Field::kSurface) {
    HWY_DYNAMIC_DISPATCH(CountMarked)(s);
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

#endif
