#include "engine/voxel/build/growing_marks.h"

#include <bit>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/voxel/build/growing_marks.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "engine/base/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace {

using Layer = GrowingMarks::Layer;
constexpr std::size_t kPart = hn::MaxLanes(W());  // rows of a vector

constexpr int kHalo = GrowingMarks::kHalo;
constexpr int kSide = GrowingMarks::kSide;
constexpr int kOctets = kSide / 8;

std::size_t RowOf(int octet) {
  return static_cast<std::size_t>(GrowingMarks::kFirstRow + 8 * octet);
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
void Turn(const Layer& layer, int z, int octet, unsigned changed, GrowingMarks& s) {
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

/// The octets that lie in the hyperchunk.
constexpr unsigned kMiddle = 0xffU << (kHalo / 8);

/// A growth of the cube of sources by `range` voxels. They are `base` voxels from those of the
/// field.
struct Growth {
  int base;
  int range;

  unsigned MarkAt(int distance) const {
    const bool marked = distance <= range && (distance > 0 || base == 0);
    return marked ? static_cast<unsigned>(kSurfaceMark + base + distance) : 0U;
  }
  /// Returns the digits in which the marks of a distance and of the next one differ.
  unsigned ChangedAt(int distance) const { return MarkAt(distance) ^ MarkAt(distance + 1); }
};

/// Notes the octets that the growth may touch, and clears the digits of those of the hyperchunk.
void ClearTouched(GrowingMarks& s, int range) {
  // by layer, octets of sources at most as many layers away as steps are done
  Octets reached = s.octets;
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
}

void TurnSources(GrowingMarks& s, const Growth& growth) {
  for (int z = kHalo; z < kHalo + kHyperchunkSide; ++z) {
    const auto layer = static_cast<std::size_t>(z);
    for (unsigned rest = s.octets[layer] & kMiddle; rest != 0; rest &= rest - 1) {
      Turn(s.cube[layer], z, std::countr_zero(rest), growth.ChangedAt(0), s);
    }
  }
}

/// Puts a layer, grown along x and y in the octets of `grown`, into the ring.
void GrowIntoRing(GrowingMarks& s, std::size_t layer, unsigned grown) {
  Layer& ring = s.ring[layer % 3];
  std::uint16_t& ring_octets = s.ring_octets[layer % 3];
  for (unsigned rest = ring_octets & ~grown; rest != 0; rest &= rest - 1) {
    ClearOctet(std::countr_zero(rest), ring);
  }
  for (unsigned rest = grown; rest != 0; rest &= rest - 1) {
    GrowInLayer(s.cube[layer], std::countr_zero(rest), ring);
  }
  ring_octets = static_cast<std::uint16_t>(grown);
}

/// Sets a layer of the cube to the union of the ring, and flips the digits of `changed` there.
void TakeFromRing(GrowingMarks& s, int z, unsigned changed) {
  const W w;
  const auto layer = static_cast<std::size_t>(z);
  const bool is_middle = z >= kHalo && z < kHalo + kHyperchunkSide;
  const unsigned met = s.ring_octets[0] | s.ring_octets[1] | s.ring_octets[2];
  for (unsigned rest = met; rest != 0; rest &= rest - 1) {
    const int octet = std::countr_zero(rest);
    const std::size_t row = RowOf(octet);
    for (std::size_t word = 0; word < 2; ++word) {
      for (std::size_t i = row; i < row + 8; i += kPart) {
        hn::Store(
            hn::Or3(hn::Load(w, &s.ring[0].words[word][i]), hn::Load(w, &s.ring[1].words[word][i]),
                    hn::Load(w, &s.ring[2].words[word][i])),
            w, &s.cube[layer].words[word][i]);
      }
    }
    if (is_middle && (kMiddle >> octet & 1U) != 0 && changed != 0) {
      Turn(s.cube[layer], z, octet, changed, s);
    }
  }
}

/// Grows the cube by a voxel. `octets`: those of sources at most step - 1 layers away, by layer.
void GrowByOne(GrowingMarks& s, const Growth& growth, int step, const Octets& octets) {
  // the part that can still reach the hyperchunk
  const int reach = growth.range - step;
  const int z0 = kHalo - reach;
  const int z1 = kHalo + kHyperchunkSide - 1 + reach;
  const int octet0 = (kHalo - reach) / 8;
  const int octet1 = (kHalo + kHyperchunkSide - 1 + reach) / 8;
  const unsigned wanted = (2U << octet1) - (1U << octet0);
  const unsigned changed = growth.ChangedAt(step);
  for (int z = z0 - 1; z <= z1 + 1; ++z) {
    // along x and y, one layer ahead of along z
    if (z >= 0 && z < kSide) {
      const auto layer = static_cast<std::size_t>(z);
      GrowIntoRing(s, layer, Spread(octets[layer], step) & wanted);
    }
    const int target = z - 1;
    if (target >= z0 && target <= z1) TakeFromRing(s, target, changed);
  }
}

/// Grows the cube of sources, which are `base` voxels from those of the field, by `range` voxels,
/// and writes the digits of the new voxels.
void Grow(GrowingMarks& s, int base, int range) {
  const Growth growth{base, range};
  ClearTouched(s, range);
  TurnSources(s, growth);
  Octets octets = s.octets;
  for (int step = 1; step <= range; ++step) {
    GrowByOne(s, growth, step, octets);
    octets = WithNeighbours(octets);
  }
}

/// Counts the voxels of the hyperchunk that have a mark.
void CountMarked(GrowingMarks& s) {
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

void GrowMarks(GrowingMarks& marks, int base, int range) {
  HWY_DYNAMIC_DISPATCH(Grow)(marks, base, range);
}

void CountMarks(GrowingMarks& marks) {
  HWY_DYNAMIC_DISPATCH(CountMarked)(marks);
}

}  // namespace tandem

#endif
