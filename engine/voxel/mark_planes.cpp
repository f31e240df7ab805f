#include "engine/voxel/mark_planes.h"

#include <algorithm>
#include <bit>
#include <cstring>

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

/// Octets that bits of these may have reached after so many steps.
unsigned Spread(unsigned octets, int steps) {
  for (int reached = 0; reached < steps; reached += 8) {
    octets |= octets << 1U | octets >> 1U;
  }
  return octets & ((1U << kOctets) - 1);
}

using Octets = std::array<std::uint16_t, kSide>;  // by layer

/// The octets of each layer and those next to it.
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

/// Turns the digits of `changed` over for the voxels of an octet of a layer that are in the cube.
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
    for (std::size_t digit = 0; digit < 4; ++digit) {
      if ((changed >> digit & 1U) == 0) continue;
      std::uint64_t* to = &s.digits[digit][out + i];
      hn::Store(hn::Xor(hn::Load(w, to), middle), w, to);
    }
  }
}

/// From the cube of sources to the digits of the marks.
void Grow(Scratch& s, int range) {
  const auto mark_at = [range](int distance) {
    return distance <= range ? static_cast<unsigned>(kSurfaceMark + distance) : 0U;
  };
  constexpr unsigned kMiddle = 0xffU << (kHalo / 8);
  const auto is_middle = [](int z) {
    return z >= kHalo && z < kHalo + kHyperchunkSide;
  };
  // by layer, octets of sources at most as many layers away as steps were taken
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
    s.written[layer] = static_cast<std::uint8_t>(touched);
    for (unsigned rest = touched; rest != 0; rest &= rest - 1) {
      const auto row = static_cast<std::size_t>(8 * std::countr_zero(rest) + kHyperchunkSide * z);
      for (auto& digit : s.digits) std::memset(&digit[row], 0, 64);
    }
  }
  for (int z = kHalo; z < kHalo + kHyperchunkSide; ++z) {
    for (unsigned rest = octets[static_cast<std::size_t>(z)] & kMiddle; rest != 0;
         rest &= rest - 1) {
      Turn(s.cube[static_cast<std::size_t>(z)], z, std::countr_zero(rest), mark_at(0) ^ mark_at(1),
           s);
    }
  }
  for (int step = 1; step <= range; ++step) {
    // what can still reach the hyperchunk
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

/// How many voxels of the hyperchunk have a mark.
void CountMarked(Scratch& s) {
  const W w;
  auto count = hn::Zero(w);
  for (std::size_t z = 0; z < kHyperchunkSide; ++z) {
    for (unsigned rest = s.written[z]; rest != 0; rest &= rest - 1) {
      const std::size_t row =
          8 * static_cast<std::size_t>(std::countr_zero(rest)) + kHyperchunkSide * z;
      for (std::size_t i = row; i < row + 8; i += kPart) {
        const Words low = hn::Or(hn::Load(w, &s.digits[0][i]), hn::Load(w, &s.digits[1][i]));
        const Words high = hn::Or(hn::Load(w, &s.digits[2][i]), hn::Load(w, &s.digits[3][i]));
        count = hn::Add(count, hn::PopulationCount(hn::Or(low, high)));
      }
    }
  }
  s.marked = hn::GetLane(hn::SumOfLanes(w, count));
}

#if HWY_TARGET == HWY_SCALAR

void TransposeOctet(const std::uint64_t* rows, std::uint64_t* words, std::size_t stride) {
  for (std::size_t x = 0; x < 8; ++x) {
    std::uint64_t word = 0;
    for (std::size_t y = 0; y < 8; ++y) word |= (rows[y] >> (8 * x) & 0xffU) << (8 * y);
    words[x * stride] = word;
  }
}

void PackNibbles(const std::uint64_t* digits, std::uint8_t* plane) {
  for (std::size_t cell = 0; cell < kVoxelsPerChunk; cell += 2) {
    std::uint64_t pair = 0;
    for (std::size_t digit = 0; digit < 4; ++digit) {
      const std::uint64_t two = digits[8 * digit + cell / 64] >> (cell % 64);
      pair |= (two & 1U) << digit | (two >> 1U & 1U) << (4 + digit);
    }
    plane[64 * QuarterOf(cell) + CellInQuarter(cell) / 2] = static_cast<std::uint8_t>(pair);
  }
}

#else

using Bytes = hn::FixedTag<std::uint8_t, 16>;
using Pairs = hn::FixedTag<std::uint16_t, 8>;
using Quads = hn::FixedTag<std::uint32_t, 4>;
using ByteVector = hn::Vec<Bytes>;

/// Eight rows of 64 voxels to the words of eight chunks' layers.
void TransposeOctet(const std::uint64_t* rows, std::uint64_t* words, std::size_t stride) {
  const Bytes b;
  const Pairs p;
  const Quads q;
  const hn::FixedTag<std::uint64_t, 2> w;
  const auto row = [&](std::size_t i) {
    return hn::BitCast(b, hn::Set(w, rows[i]));
  };
  const auto ab = hn::BitCast(p, hn::InterleaveLower(b, row(0), row(1)));
  const auto cd = hn::BitCast(p, hn::InterleaveLower(b, row(2), row(3)));
  const auto ef = hn::BitCast(p, hn::InterleaveLower(b, row(4), row(5)));
  const auto gh = hn::BitCast(p, hn::InterleaveLower(b, row(6), row(7)));
  const auto low_abcd = hn::BitCast(q, hn::InterleaveLower(p, ab, cd));
  const auto high_abcd = hn::BitCast(q, hn::InterleaveUpper(p, ab, cd));
  const auto low_efgh = hn::BitCast(q, hn::InterleaveLower(p, ef, gh));
  const auto high_efgh = hn::BitCast(q, hn::InterleaveUpper(p, ef, gh));
  alignas(16) std::array<std::uint64_t, 8> out;
  hn::Store(hn::BitCast(w, hn::InterleaveLower(q, low_abcd, low_efgh)), w, &out[0]);
  hn::Store(hn::BitCast(w, hn::InterleaveUpper(q, low_abcd, low_efgh)), w, &out[2]);
  hn::Store(hn::BitCast(w, hn::InterleaveLower(q, high_abcd, high_efgh)), w, &out[4]);
  hn::Store(hn::BitCast(w, hn::InterleaveUpper(q, high_abcd, high_efgh)), w, &out[6]);
  for (std::size_t i = 0; i < 8; ++i) words[i * stride] = out[i];
}

/// 512 marks of 4 bits from their digits (8 words each), quarter after quarter.
void PackNibbles(const std::uint64_t* digits, std::uint8_t* plane) {
  const Bytes b;
  const Pairs p;
  const hn::FixedTag<std::uint64_t, 2> w;
  const auto swap = [&](auto& low, auto& high, auto shift, std::uint64_t mask) {
    constexpr int kShift = decltype(shift)::value;
    const auto t = hn::And(hn::Xor(hn::ShiftRight<kShift>(low), high), hn::Set(w, mask));
    high = hn::Xor(high, t);
    low = hn::Xor(low, hn::ShiftLeft<kShift>(t));
  };
  const auto low_nibbles = hn::Set(w, 0x0f0f0f0f0f0f0f0fU);
  for (std::size_t i = 0; i < 8; i += 2) {
    auto v0 = hn::Load(w, digits + i);
    auto v1 = hn::Load(w, digits + 8 + i);
    auto v2 = hn::Load(w, digits + 16 + i);
    auto v3 = hn::Load(w, digits + 24 + i);
    // squares of 4 digits by 4 voxels, turned over
    using One = std::integral_constant<int, 1>;
    using Two = std::integral_constant<int, 2>;
    swap(v0, v2, Two{}, 0x3333333333333333U);
    swap(v1, v3, Two{}, 0x3333333333333333U);
    swap(v0, v1, One{}, 0x5555555555555555U);
    swap(v2, v3, One{}, 0x5555555555555555U);
    const auto pair = [&](const auto& low, const auto& high) {
      return hn::Or(hn::And(low, low_nibbles), hn::ShiftLeft<4>(hn::And(high, low_nibbles)));
    };
    const auto odd_pair = [&](const auto& low, const auto& high) {
      return hn::Or(hn::And(hn::ShiftRight<4>(low), low_nibbles), hn::AndNot(low_nibbles, high));
    };
    const ByteVector a_even = hn::BitCast(b, pair(v0, v1));
    const ByteVector b_even = hn::BitCast(b, pair(v2, v3));
    const ByteVector a_odd = hn::BitCast(b, odd_pair(v0, v1));
    const ByteVector b_odd = hn::BitCast(b, odd_pair(v2, v3));
    const auto low_even = hn::BitCast(p, hn::InterleaveLower(b, a_even, b_even));
    const auto low_odd = hn::BitCast(p, hn::InterleaveLower(b, a_odd, b_odd));
    const auto high_even = hn::BitCast(p, hn::InterleaveUpper(b, a_even, b_even));
    const auto high_odd = hn::BitCast(p, hn::InterleaveUpper(b, a_odd, b_odd));
    // layers i and i + 1, four rows of each in a quarter
    std::uint8_t* to = plane + 128 * (i / 4) + 16 * (i % 4);
    hn::StoreU(hn::BitCast(b, hn::InterleaveLower(p, low_even, low_odd)), b, to);
    hn::StoreU(hn::BitCast(b, hn::InterleaveUpper(p, low_even, low_odd)), b, to + 64);
    hn::StoreU(hn::BitCast(b, hn::InterleaveLower(p, high_even, high_odd)), b, to + 16);
    hn::StoreU(hn::BitCast(b, hn::InterleaveUpper(p, high_even, high_odd)), b, to + 80);
  }
}

#endif

/// The digits of the eight chunks along x at (cy, cz), 4 times 8 words each. `inside` and `surface`
/// as rows of the hyperchunk; `solid`: all is inside. Bits 0 to 7: the chunk has digits, bits 8 to
/// 15: all of it is inside.
unsigned GatherChunks(const Scratch& s, std::size_t cy, std::size_t cz, const std::uint64_t* inside,
                      const SurfaceBricks::Source* surface, bool solid,
                      MarkPlanes::Chunks& chunks) {
  const W w;
  const bool filled = inside != nullptr || solid;
  alignas(64) static constexpr std::array<std::uint64_t, 8> kNoRows{};
  for (std::size_t k = 0; k < 8; ++k) {
    const std::size_t z = 8 * cz + k;
    const std::size_t row = 8 * cy + kHyperchunkSide * z;
    const bool written = (s.written[z] >> cy & 1U) != 0;
    if (!filled) {
      for (std::size_t digit = 0; digit < 4; ++digit) {
        TransposeOctet(written ? &s.digits[digit][row] : kNoRows.data(), &chunks[0][8 * digit + k],
                       32);
      }
      continue;
    }
    alignas(64) std::array<std::uint64_t, 8> in;
    const std::uint64_t* taken = surface != nullptr ? surface->Octet(z, cy) : nullptr;
    for (std::size_t i = 0; i < 8; i += kPart) {
      Words v = solid ? hn::Set(w, ~std::uint64_t{0}) : hn::LoadU(w, inside + row + i);
      if (taken != nullptr) v = hn::AndNot(hn::LoadU(w, taken + i), v);
      hn::Store(v, w, &in[i]);
    }
    for (std::size_t digit = 0; digit < 4; ++digit) {
      alignas(64) std::array<std::uint64_t, 8> rows;
      for (std::size_t i = 0; i < 8; i += kPart) {
        const Words v = hn::Load(w, &in[i]);
        const Words was = written ? hn::Load(w, &s.digits[digit][row + i]) : hn::Zero(w);
        hn::Store(digit == 0 ? hn::Or(was, v) : hn::AndNot(v, was), w, &rows[i]);
      }
      TransposeOctet(rows.data(), &chunks[0][8 * digit + k], 32);
    }
  }
  unsigned kinds = 0;
  for (std::size_t cx = 0; cx < 8; ++cx) {
    const std::uint64_t* digits = chunks[cx].data();
    Words ones = hn::Zero(w);
    Words all = hn::Set(w, ~std::uint64_t{0});
    Words higher = hn::Zero(w);
    for (std::size_t i = 0; i < 8; i += kPart) {
      const Words v = hn::Load(w, digits + i);
      ones = hn::Or(ones, v);
      all = hn::And(all, v);
      for (std::size_t digit = 1; digit < 4; ++digit) {
        higher = hn::Or(higher, hn::Load(w, digits + 8 * digit + i));
      }
    }
    const auto none = hn::Zero(w);
    const bool no_higher = hn::AllTrue(w, hn::Eq(higher, none));
    if (no_higher && hn::AllTrue(w, hn::Eq(ones, none))) continue;
    const bool whole = no_higher && hn::AllTrue(w, hn::Eq(all, hn::Set(w, ~std::uint64_t{0})));
    kinds |= 1U << (cx + (whole ? 8U : 0U));
  }
  return kinds;
}

}  // namespace
}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace tandem {

namespace {

HWY_EXPORT(CountMarked);
HWY_EXPORT(Grow);
HWY_EXPORT(GatherChunks);
HWY_EXPORT(PackNibbles);

/// Marks of 2 or 8 bits.
void PackOthers(const std::uint64_t* digits, int bits, std::uint8_t* plane) {
  std::memset(plane, 0, kVoxelsPerChunk / 8 * static_cast<std::size_t>(bits));
  for (std::size_t digit = 0; digit < 4; ++digit) {
    for (std::size_t word = 0; word < 8; ++word) {
      for (std::uint64_t rest = digits[8 * digit + word]; rest != 0; rest &= rest - 1) {
        const std::size_t cell = 64 * word + static_cast<std::size_t>(std::countr_zero(rest));
        const std::size_t place = kVoxelsPerQuarter * QuarterOf(cell) + CellInQuarter(cell);
        const std::size_t bit = place * static_cast<std::size_t>(bits) + digit;
        plane[bit >> 3U] = static_cast<std::uint8_t>(plane[bit >> 3U] | 1U << (bit & 7U));
      }
    }
  }
}

}  // namespace

MarkPlanes::MarkPlanes(const SurfaceBricks& bricks, int range, int bits)
    : bricks_(bricks), range_(range), bits_(bits), scratch_(std::make_unique<Scratch>()) {}

void MarkPlanes::Begin(const GridIndex& place) {
  place_ = place;
  record_ = {};
  planes_.clear();
  plane_count_ = 0;
  band_voxels_ = 0;
}

/// Sets the cube to the sources in and round the hyperchunk. Whether there are any.
bool MarkPlanes::Gather(Field field) {
  Scratch& s = *scratch_;
  s.octets.fill(0);
  std::array<const SurfaceBricks::Source*, 27> near{};
  bool any = false;
  for (std::int32_t n = 0; n < 27; ++n) {
    const GridIndex offset{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
    const SurfaceBricks::Brick* brick = bricks_.At(place_ + offset);
    if (brick == nullptr) continue;
    const SurfaceBricks::Source& source = brick->sources[static_cast<std::size_t>(field)];
    if (source.empty()) continue;
    near[static_cast<std::size_t>(n)] = &source;
    any = true;
  }
  if (!any) return false;
  any = false;
  // whole octets, though some rows of theirs are out of reach
  const int reach = (range_ + 7) / 8 * 8;
  for (int z = -range_; z < kHyperchunkSide + range_; ++z) {
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

void MarkPlanes::Add(Field field, const std::uint64_t* inside, bool solid) {
  Scratch& s = *scratch_;
  const bool sources = Gather(field);
  s.written.fill(0);
  if (sources) {
    HWY_DYNAMIC_DISPATCH(Grow)(s, range_);
    for (std::size_t z = 0; z < kSide; ++z) {
      for (unsigned rest = s.touched[z]; rest != 0; rest &= rest - 1) {
        const auto row = static_cast<std::size_t>(kFirstRow + 8 * std::countr_zero(rest));
        for (auto& word : s.cube[z].words) std::fill_n(&word[row], 8, 0);
      }
    }
    if (field == Field::kSurface) {
      HWY_DYNAMIC_DISPATCH(CountMarked)(s);
      band_voxels_ = s.marked;
    }
  }
  const auto f = static_cast<std::size_t>(field);
  const SurfaceBricks::Brick* brick = bricks_.At(place_);
  const std::size_t plane_bytes = kVoxelsPerChunk / 8 * static_cast<std::size_t>(bits_);
  const SurfaceBricks::Source* surface =
      brick != nullptr && !brick->sources[0].empty() ? &brick->sources[0] : nullptr;
  alignas(64) Chunks chunks;
  for (std::size_t cz = 0; cz < 8; ++cz) {
    VoxmapSlice& slice = record_.slices[f][cz];
    slice.first_plane = plane_count_;
    for (std::size_t cy = 0; cy < 8; ++cy) {
      bool any = false;
      for (std::size_t z = 8 * cz; z < 8 * cz + 8; ++z) any |= (s.written[z] >> cy & 1U) != 0;
      if (!any && inside == nullptr && !solid) continue;
      const unsigned kinds =
          HWY_DYNAMIC_DISPATCH(GatherChunks)(s, cy, cz, inside, surface, solid, chunks);
      record_.solid[cz] |= std::uint64_t{kinds >> 8U} << (8 * cy);
      slice.stored |= std::uint64_t{kinds & 0xffU} << (8 * cy);
      for (unsigned rest = kinds & 0xffU; rest != 0; rest &= rest - 1) {
        const auto& digits = chunks[static_cast<std::size_t>(std::countr_zero(rest))];
        ++plane_count_;
        planes_.resize(planes_.size() + plane_bytes);
        std::uint8_t* plane = &planes_[planes_.size() - plane_bytes];
        if (bits_ == 4) {
          HWY_DYNAMIC_DISPATCH(PackNibbles)(digits.data(), plane);
        } else {
          PackOthers(digits.data(), bits_, plane);
        }
      }
    }
  }
}

}  // namespace tandem

#endif
