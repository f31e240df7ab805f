#include "engine/voxel/voxmap.h"

#include <algorithm>
#include <utility>

#include "engine/base/check.h"
#include "engine/base/hash.h"

namespace tandem {

namespace {

constexpr std::uint8_t kTwoInterior = kInteriorMark | kInteriorMark << 4;

int StoredMark(const Voxmap::Chunk& chunk, std::size_t cell) {
  return chunk[cell >> 1] >> ((cell & 1) * 4) & 15;
}

}  // namespace

Voxmap::Voxmap(double voxel_size, int range, GridIndex origin, GridIndex size)
    : voxel_size_(voxel_size), range_(range), origin_(origin) {
  TANDEM_CHECK(voxel_size > 0 && range >= 1 && range <= kMaxRange);
  TANDEM_CHECK(origin.x % kHyperchunkSide == 0 && origin.y % kHyperchunkSide == 0 &&
               origin.z % kHyperchunkSide == 0);
  size_ = {static_cast<std::uint32_t>(size.x), static_cast<std::uint32_t>(size.y),
           static_cast<std::uint32_t>(size.z)};
  for (std::size_t k = 0; k < 3; ++k) limit_[k] = size_[k] * kHyperchunkSide;
  hyperchunks_.assign(std::size_t{size_[0]} * size_[1] * size_[2], kAllBeyond);
  tables_.resize(2);
  tables_[kAllBeyond].fill(kAllBeyond);
  tables_[kAllInterior].fill(kAllInterior);
  chunks_.resize(2);
  chunks_[kAllBeyond].fill(0);
  chunks_[kAllInterior].fill(kTwoInterior);
}

Vec3 Voxmap::extent() const noexcept {
  return voxel_size_ * Vec3(limit_[0], limit_[1], limit_[2]);
}

std::size_t Voxmap::TableSlot(const GridIndex& hyperchunk) const {
  return static_cast<std::size_t>(hyperchunk.x) +
         size_[0] * (static_cast<std::size_t>(hyperchunk.y) +
                     std::size_t{size_[1]} * static_cast<std::size_t>(hyperchunk.z));
}

void Voxmap::SetUniform(const GridIndex& hyperchunk, std::uint32_t all_beyond_or_interior) {
  hyperchunks_[TableSlot(hyperchunk)] = all_beyond_or_interior;
}

void Voxmap::SetHyperchunk(const GridIndex& hyperchunk, const std::vector<Mark>& marks,
                           const ChunkTable& uniform) {
  hyperchunks_[TableSlot(hyperchunk)] = static_cast<std::uint32_t>(tables_.size());
  ChunkTable& table = tables_.emplace_back();
  for (std::size_t c = 0; c < kChunksPerHyperchunk; ++c) {
    if (uniform[c] != kStored) {
      table[c] = uniform[c];
      continue;
    }
    table[c] = static_cast<std::uint32_t>(chunks_.size());
    Chunk& chunk = chunks_.emplace_back();
    const GridIndex first = BlockCell(c) * kChunkSide;
    for (std::size_t cell = 0; cell < kVoxelsPerChunk; cell += 2) {
      const GridIndex i = first + BlockCell(cell);
      const std::size_t m =
          static_cast<std::size_t>(i.x + kHyperchunkSide * (i.y + kHyperchunkSide * i.z));
      chunk[cell >> 1] = static_cast<std::uint8_t>(marks[m] | marks[m + 1] << 4);
    }
  }
}

VoxelCounts Voxmap::Count() const {
  VoxelCounts counts;
  counts.chunks = chunks_.size() - 2;
  counts.hyperchunks = tables_.size() - 2;
  for (std::size_t c = 2; c < chunks_.size(); ++c) {
    for (std::size_t cell = 0; cell < kVoxelsPerChunk; ++cell) {
      const int mark = StoredMark(chunks_[c], cell);
      counts.interior += mark == kInteriorMark;
      counts.surface += mark == kSurfaceMark;
      counts.free += mark > kSurfaceMark;
    }
  }
  counts.bytes = sizeof(Voxmap) + hyperchunks_.size() * sizeof(hyperchunks_[0]) +
                 tables_.size() * sizeof(ChunkTable) + chunks_.size() * sizeof(Chunk);
  return counts;
}

std::uint64_t Voxmap::Digest() const {
  // places of all chunks that are not beyond, sorted so that the order of building does not show
  std::vector<std::pair<std::uint64_t, std::uint32_t>> places;
  for (std::uint32_t z = 0; z < size_[2]; ++z) {
    for (std::uint32_t y = 0; y < size_[1]; ++y) {
      for (std::uint32_t x = 0; x < size_[0]; ++x) {
        const GridIndex hyperchunk{static_cast<std::int32_t>(x), static_cast<std::int32_t>(y),
                                   static_cast<std::int32_t>(z)};
        const std::uint32_t table = hyperchunks_[TableSlot(hyperchunk)];
        if (table == kAllBeyond) continue;
        for (std::size_t c = 0; c < kChunksPerHyperchunk; ++c) {
          if (tables_[table][c] == kAllBeyond) continue;
          const GridIndex chunk = (origin_ >> 3) + hyperchunk * kChunkSide + BlockCell(c);
          places.emplace_back(MortonCode(chunk), tables_[table][c]);
        }
      }
    }
  }
  std::sort(places.begin(), places.end());
  Hash64 hash;
  for (const auto& [code, chunk] : places) {
    hash.Add(code);
    hash.AddBytes(chunks_[chunk].data(), chunks_[chunk].size());
  }
  return hash.value();
}

}  // namespace tandem
