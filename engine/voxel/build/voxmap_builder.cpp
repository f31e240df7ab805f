#include "engine/voxel/build/voxmap_builder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

#include <tbb/parallel_for.h>

#include "engine/base/check.h"

namespace tandem {

namespace {

/// The chunks that bear any mark, or are solid: by z, bit x + 8 y.
using Bearing = std::array<std::uint64_t, kChunkSide>;

Bearing BearingOf(const VoxmapRecord& record) {
  Bearing bearing = record.solid;
  for (const auto& slices : record.slices) {
    for (std::size_t z = 0; z < bearing.size(); ++z) bearing[z] |= slices[z].stored;
  }
  return bearing;
}

constexpr std::size_t kCubeSide = 3 * kChunkSide;
struct ChunkCube {  // rows along x, by z and y
  std::array<std::array<std::uint32_t, kCubeSide>, kCubeSide> rows{};
};

/// Grows the cube by one chunk in all directions, for the `distance`th time; `spare` is scratch.
/// Chunks that cannot reach the middle any more stay as they are.
void Grow(ChunkCube& cube, ChunkCube& spare, std::size_t distance) {
  const std::size_t first = distance;
  const std::size_t end = kCubeSide - distance;
  for (std::size_t z = first - 1; z < end + 1; ++z) {
    const auto& from = cube.rows[z];
    auto& to = spare.rows[z];
    for (std::size_t y = first; y < end; ++y) {
      const std::uint32_t row = from[y - 1] | from[y] | from[y + 1];
      to[y] = row | row << 1U | row >> 1U;
    }
  }
  for (std::size_t z = first; z < end; ++z) {
    const auto& below = spare.rows[z - 1];
    const auto& here = spare.rows[z];
    const auto& above = spare.rows[z + 1];
    for (std::size_t y = first; y < end; ++y) cube.rows[z][y] = below[y] | here[y] | above[y];
  }
}

/// Returns a hash, 0 for zeros alone.
std::uint64_t HashOf(const std::uint8_t* bytes, std::size_t count) {
  constexpr std::uint64_t kOdd = 0x9e3779b97f4a7c15U;
  std::array<std::uint64_t, 4> sums{1, 2, 3, 4};
  std::uint64_t any = 0;
  for (std::size_t i = 0; i < count; i += 32) {
    std::array<std::uint64_t, 4> words;
    std::memcpy(words.data(), bytes + i, 32);
    for (std::size_t k = 0; k < 4; ++k) {
      any |= words[k];
      sums[k] = std::rotl((sums[k] ^ words[k]) * kOdd, 29);
    }
  }
  if (any == 0) return 0;
  std::uint64_t hash = 0;
  for (const std::uint64_t sum : sums) hash = std::rotl((hash ^ sum) * kOdd, 31);
  hash *= kOdd;
  return hash != 0 ? hash : 1;
}

}  // namespace

VoxmapBuilder::VoxmapBuilder(double voxel_size, int range, int bits, const HyperchunkBox& box,
                             const std::vector<Kind>& kinds)
    : box_(box), quarter_bytes_(kVoxelsPerQuarter / 8 * static_cast<std::size_t>(bits)) {
  TANDEM_CHECK(voxel_size > 0 && (bits == 2 || bits == 4 || bits == 8));
  TANDEM_CHECK(range >= 1 && range <= WidestRange(bits) && kinds.size() == box.cells());
  // hyperchunks next to marked or solid ones have a record too, with the distance of those
  std::vector<std::uint8_t> near(box.cells(), 0);
  std::size_t marked = 0;
  for (std::int32_t z = 1; z + 1 < box.size.z; ++z) {
    for (std::int32_t y = 1; y + 1 < box.size.y; ++y) {
      for (std::int32_t x = 1; x + 1 < box.size.x; ++x) {
        const GridIndex place = box.first + GridIndex{x, y, z};
        const Kind kind = kinds[box.CellOf(place)];
        if (kind == Kind::kFar) continue;
        marked += kind == Kind::kMarked;
        for (std::int32_t n = 0; n < 27; ++n) {
          near[box.CellOf(place + GridIndex{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1})] = 1;
        }
      }
    }
  }
  std::size_t records = 2;
  for (std::size_t c = 0; c < near.size(); ++c) {
    records += near[c] != 0 && kinds[c] != Kind::kSolid ? 1U : 0U;
  }
  LayOut(voxel_size, range, bits, records, marked);
  AddFirstEntries(bits);
  for (std::size_t c = 0; c < near.size(); ++c) {
    if (kinds[c] == Kind::kSolid) {
      index_[c] = kRecordSolid;
    } else if (near[c] != 0) {
      index_[c] = static_cast<std::uint32_t>(header_.record_count++);
      records_[index_[c]] = {};
    }
  }
}

void VoxmapBuilder::LayOut(double voxel_size, int range, int bits, std::size_t records,
                           std::size_t marked) {
  const auto aligned = [](std::size_t bytes) {
    return (bytes + 63) / 64 * 64;
  };
  header_.magic = {'t', 'a', 'n', 'd', 'e', 'm', 'V', 'M'};
  header_.version = kVoxmapVersion;
  header_.bits = static_cast<std::uint32_t>(bits);
  header_.range = static_cast<std::uint32_t>(range);
  header_.voxel_size = voxel_size;
  header_.origin = {box_.first.x * kHyperchunkSide, box_.first.y * kHyperchunkSide,
                    box_.first.z * kHyperchunkSide};
  header_.size = {static_cast<std::uint32_t>(box_.size.x), static_cast<std::uint32_t>(box_.size.y),
                  static_cast<std::uint32_t>(box_.size.z)};
  header_.index_offset = sizeof(VoxmapHeader);
  header_.records_offset = aligned(header_.index_offset + box_.cells() * sizeof(std::uint32_t));
  header_.record_count = 2;
  header_.quarters_offset = header_.records_offset + records * sizeof(VoxmapRecord);
  header_.quarter_count = 2;
  const std::size_t most_planes = 2 + marked * kFields * kChunksPerHyperchunk;
  image_ = ImageBytes(header_.quarters_offset +
                      most_planes * (kQuarters * quarter_bytes_ + sizeof(VoxmapPlane)));
  index_ = reinterpret_cast<std::uint32_t*>(image_.data() + header_.index_offset);
  records_ = reinterpret_cast<VoxmapRecord*>(image_.data() + header_.records_offset);
  quarters_ = reinterpret_cast<std::uint8_t*>(image_.data() + header_.quarters_offset);
}

void VoxmapBuilder::AddFirstEntries(int bits) {
  planes_ = {VoxmapPlane{}, VoxmapPlane{}};
  planes_[kPlaneInterior].quarters.fill(kQuarterInterior);
  // one mark of 1 after another: its lowest bit at every mark's place
  const int ones = bits == 2 ? 0x55 : (bits == 4 ? 0x11 : 0x01);
  std::memset(quarters_ + kQuarterInterior * quarter_bytes_, ones, quarter_bytes_);
  number_at_.assign(1U << 13U, 0);
  const std::uint64_t interior =
      HashOf(quarters_ + kQuarterInterior * quarter_bytes_, quarter_bytes_);
  number_at_[interior >> 32U & (number_at_.size() - 1)] = interior >> 32U << 32U | kQuarterInterior;
  records_[kRecordFar] = {};
  records_[kRecordSolid] = {};
  records_[kRecordSolid].solid.fill(~std::uint64_t{0});
  records_[kRecordSolid].chunk_marks.fill(kSurfaceMark | kSurfaceMark << 4);
}

/// Returns the number of a quarter with these bytes, which is kept if there is none like it yet.
std::uint32_t VoxmapBuilder::NumberOf(const std::uint8_t* quarter, std::uint64_t hash) {
  const std::uint64_t mask = number_at_.size() - 1;
  const std::uint64_t tag = hash >> 32U << 32U;
  for (std::uint64_t at = hash >> 32U & mask;; at = (at + 1) & mask) {
    const auto number = static_cast<std::uint32_t>(number_at_[at]);
    if (number == 0) {
      number_at_[at] = tag | header_.quarter_count;
      break;
    }
    if ((number_at_[at] ^ tag) >> 32U == 0 &&
        std::memcmp(quarters_ + number * quarter_bytes_, quarter, quarter_bytes_) == 0) {
      return number;
    }
  }
  std::memcpy(quarters_ + header_.quarter_count * quarter_bytes_, quarter, quarter_bytes_);
  return static_cast<std::uint32_t>(header_.quarter_count++);
}

void VoxmapBuilder::Widen() {
  std::vector<std::uint64_t> wider(4 * number_at_.size(), 0);
  const std::uint64_t mask = wider.size() - 1;
  for (const std::uint64_t entry : number_at_) {
    if (entry == 0) continue;
    std::uint64_t at = entry >> 32U & mask;
    while (wider[at] != 0) at = (at + 1) & mask;
    wider[at] = entry;
  }
  number_at_ = std::move(wider);
}

void VoxmapBuilder::Add(const GridIndex& place, const VoxmapRecord& record,
                        std::span<const std::uint8_t> planes) {
  VoxmapRecord& out = records_[index_[box_.CellOf(place)]];
  out = record;
  if (planes.empty()) return;
  for (auto& slices : out.slices) {
    for (VoxmapSlice& slice : slices) {
      slice.first_plane += static_cast<std::uint32_t>(planes_.size());
    }
  }
  const std::size_t quarters = planes.size() / quarter_bytes_;
  while (2 * (header_.quarter_count + quarters) > number_at_.size()) Widen();
  hashes_.resize(quarters);
  for (std::size_t q = 0; q < quarters; ++q) {
    hashes_[q] = HashOf(&planes[q * quarter_bytes_], quarter_bytes_);
  }
  // prefetches the table's entries, then the quarters that they name
  constexpr std::size_t kEntryAhead = 16;
  constexpr std::size_t kQuarterAhead = 8;
  const std::uint64_t mask = number_at_.size() - 1;
  for (std::size_t q = 0; q < quarters; ++q) {
    if (q + kEntryAhead < quarters) {
      __builtin_prefetch(&number_at_[hashes_[q + kEntryAhead] >> 32U & mask]);
    }
    if (q + kQuarterAhead < quarters) {
      const std::uint64_t entry = number_at_[hashes_[q + kQuarterAhead] >> 32U & mask];
      __builtin_prefetch(quarters_ + static_cast<std::uint32_t>(entry) * quarter_bytes_);
    }
    if (q % kQuarters == 0) planes_.emplace_back();
    planes_.back().quarters[q % kQuarters] =
        hashes_[q] == 0 ? kQuarterBeyond : NumberOf(&planes[q * quarter_bytes_], hashes_[q]);
  }
}

/// Fills every record's marks in units of chunks, from the chunks of the 3 x 3 x 3 hyperchunks
/// round it that bear marks.
void VoxmapBuilder::FillChunkLevel() {
  std::vector<Bearing> bearing(header_.record_count);
  for (std::size_t r = 1; r < bearing.size(); ++r) bearing[r] = BearingOf(records_[r]);
  tbb::parallel_for(std::size_t{0}, box_.cells(), [&](std::size_t cell) {
    if (index_[cell] <= kRecordSolid) return;
    const GridIndex place = box_.PlaceOf(cell);
    ChunkCube cube;
    std::uint64_t any = 0;
    for (std::int32_t n = 0; n < 27; ++n) {
      const GridIndex offset{n % 3, n / 3 % 3, n / 9};
      const GridIndex other = place + offset - GridIndex{1, 1, 1};
      if (!box_.Holds(other)) continue;
      const Bearing& theirs = bearing[index_[box_.CellOf(other)]];
      for (std::size_t z = 0; z < 8; ++z) {
        any |= theirs[z];
        if (theirs[z] == 0) continue;
        auto* rows = &cube.rows[static_cast<std::size_t>(offset.z) * 8 + z]
                               [static_cast<std::size_t>(offset.y) * 8];
        for (std::size_t y = 0; y < 8; ++y) {
          rows[y] |= static_cast<std::uint32_t>(theirs[z] >> (8 * y) & 0xffU) << (8 * offset.x);
        }
      }
    }
    if (any == 0) return;
    ChunkCube spare;
    std::array<std::uint8_t, kChunksPerHyperchunk / 2>& marks = records_[index_[cell]].chunk_marks;
    std::array<std::uint8_t, 64> done{};  // per row y + 8 z
    for (int distance = 0; distance <= Voxmap::kChunkRange; ++distance) {
      if (distance > 0) Grow(cube, spare, static_cast<std::size_t>(distance));
      unsigned all = 0xff;
      for (std::size_t row = 0; row < 64; ++row) {
        const unsigned set = cube.rows[8 + (row >> 3U)][8 + (row & 7U)] >> 8U & 0xffU;
        for (unsigned rest = set & ~static_cast<unsigned>(done[row]); rest != 0; rest &= rest - 1) {
          const auto x = static_cast<std::size_t>(std::countr_zero(rest));
          std::uint8_t& pair = marks[4 * row + x / 2];
          pair = static_cast<std::uint8_t>(pair | (kSurfaceMark + distance) << (4 * (x & 1U)));
        }
        done[row] = static_cast<std::uint8_t>(set);
        all &= set;
      }
      if (all == 0xff) break;
    }
  });
}

Voxmap VoxmapBuilder::FinishOutline(std::uint64_t band_voxels) {
  TANDEM_CHECK(planes_.size() == 2);
  FillChunkLevel();
  for (std::uint64_t r = 2; r < header_.record_count; ++r) records_[r].slices = {};
  return Written(band_voxels);
}

Voxmap VoxmapBuilder::Finish(std::uint64_t band_voxels) {
  FillChunkLevel();
  return Written(band_voxels);
}

Voxmap VoxmapBuilder::Written(std::uint64_t band_voxels) {
  header_.band_voxels = band_voxels;
  header_.planes_offset = header_.quarters_offset + header_.quarter_count * quarter_bytes_;
  header_.plane_count = planes_.size();
  header_.bytes = header_.planes_offset + planes_.size() * sizeof(VoxmapPlane);
  std::memcpy(image_.data() + header_.planes_offset, planes_.data(),
              planes_.size() * sizeof(VoxmapPlane));
  std::memcpy(image_.data(), &header_, sizeof header_);
  image_.Shrink(header_.bytes);
  return Voxmap(std::move(image_));
}

}  // namespace tandem
