#include "engine/voxel/build/mark_packing.h"

#include <bit>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/voxel/build/mark_packing.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "engine/base/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace {

constexpr std::size_t kPart = hn::MaxLanes(W());  // rows of a vector
constexpr std::size_t kChunkStride = std::tuple_size_v<ChunkDigits::value_type>;

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

/// Transposes eight rows of 64 voxels to the words of eight chunks' layers.
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

/// Packs 512 marks of 4 bits from their digits (8 words each), quarter after quarter.
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
    // transposes squares of 4 digits by 4 voxels
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

template <std::size_t kDigits>
unsigned GatherDigits(const MarkDigits& s, std::size_t cy, std::size_t cz,
                      const std::uint64_t* inside, const SurfaceBricks::Source* surface, bool solid,
                      ChunkDigits& chunks) {
  const W w;
  const bool filled = inside != nullptr || solid;
  alignas(64) static constexpr std::array<std::uint64_t, 8> kNoRows{};
  for (std::size_t k = 0; k < 8; ++k) {
    const std::size_t z = 8 * cz + k;
    const std::size_t row = 8 * cy + kHyperchunkSide * z;
    const bool written = (s.written[z] >> cy & 1U) != 0;
    if (!filled) {
      for (std::size_t digit = 0; digit < kDigits; ++digit) {
        TransposeOctet(written ? &s.rows[digit][row] : kNoRows.data(), &chunks[0][8 * digit + k],
                       kChunkStride);
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
    for (std::size_t digit = 0; digit < kDigits; ++digit) {
      alignas(64) std::array<std::uint64_t, 8> rows;
      for (std::size_t i = 0; i < 8; i += kPart) {
        const Words v = hn::Load(w, &in[i]);
        const Words was = written ? hn::Load(w, &s.rows[digit][row + i]) : hn::Zero(w);
        hn::Store(digit == 0 ? hn::Or(was, v) : hn::AndNot(v, was), w, &rows[i]);
      }
      TransposeOctet(rows.data(), &chunks[0][8 * digit + k], kChunkStride);
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
      for (std::size_t digit = 1; digit < kDigits; ++digit) {
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

unsigned GatherFour(const MarkDigits& s, std::size_t cy, std::size_t cz,
                    const std::uint64_t* inside, const SurfaceBricks::Source* surface, bool solid,
                    ChunkDigits& chunks) {
  return GatherDigits<4>(s, cy, cz, inside, surface, solid, chunks);
}

unsigned GatherEight(const MarkDigits& s, std::size_t cy, std::size_t cz,
                     const std::uint64_t* inside, const SurfaceBricks::Source* surface, bool solid,
                     ChunkDigits& chunks) {
  return GatherDigits<8>(s, cy, cz, inside, surface, solid, chunks);
}

}  // namespace
}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace tandem {

namespace {

HWY_EXPORT(GatherFour);
HWY_EXPORT(GatherEight);
HWY_EXPORT(PackNibbles);

/// Packs marks of 2 or 8 bits.
void PackOthers(const std::uint64_t* digits, int bits, std::uint8_t* plane) {
  std::memset(plane, 0, kVoxelsPerChunk / 8 * static_cast<std::size_t>(bits));
  for (std::size_t digit = 0; digit < static_cast<std::size_t>(bits); ++digit) {
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

unsigned GatherChunks(const MarkDigits& digits, std::size_t cy, std::size_t cz,
                      const std::uint64_t* inside, const SurfaceBricks::Source* surface, bool solid,
                      ChunkDigits& chunks) {
  return digits.count == 4
             ? HWY_DYNAMIC_DISPATCH(GatherFour)(digits, cy, cz, inside, surface, solid, chunks)
             : HWY_DYNAMIC_DISPATCH(GatherEight)(digits, cy, cz, inside, surface, solid, chunks);
}

void PackMarks(const std::uint64_t* digits, int bits, std::uint8_t* plane) {
  if (bits == 4) {
    HWY_DYNAMIC_DISPATCH(PackNibbles)(digits, plane);
  } else {
    PackOthers(digits, bits, plane);
  }
}

}  // namespace tandem

#endif
