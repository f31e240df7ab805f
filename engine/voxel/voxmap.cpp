#include "engine/voxel/voxmap.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "engine/base/check.h"
#include "engine/base/hash.h"

namespace tandem {

Voxmap::Voxmap(ImageBytes image)
    : image_(std::make_shared<const ImageBytes>(std::move(image))),
      header_(reinterpret_cast<const VoxmapHeader*>(image_->data())) {
  TANDEM_CHECK(image_->size() >= sizeof(VoxmapHeader) && header_->bytes == image_->size());
}

Vec3 Voxmap::extent() const noexcept {
  const auto& size = header().size;
  return kHyperchunkSide * voxel_size() * Vec3(size[0], size[1], size[2]);
}

VoxelCounts Voxmap::Count() const {
  VoxelCounts counts;
  if (empty()) return counts;
  counts.planes = header().plane_count - 2;
  counts.quarters = header().quarter_count - 2;
  counts.hyperchunks = header().record_count - 2;
  counts.bytes = header().bytes;
  counts.band = header().band_voxels;
  for (std::size_t r = 2; r < header().record_count; ++r) {
    for (std::size_t field = 0; field < kFields; ++field) {
      for (const VoxmapSlice& slice : records()[r].slices[field]) {
        const auto stored = static_cast<std::uint32_t>(std::popcount(slice.stored));
        for (std::uint32_t p = slice.first_plane; p < slice.first_plane + stored; ++p) {
          const std::size_t surface_before = counts.surface;
          for (std::size_t cell = 0; cell < kVoxelsPerChunk; ++cell) {
            const int mark = StoredMark(p, cell);
            if (field == 1) counts.edge += mark == kSurfaceMark;
            if (field == 2) counts.vertex += mark == kSurfaceMark;
            if (field != 0) continue;
            counts.interior += mark == kInteriorMark;
            counts.surface += mark == kSurfaceMark;
            counts.free += mark > kSurfaceMark;
          }
          counts.surface_chunks += counts.surface > surface_before ? 1U : 0U;
        }
      }
    }
  }
  return counts;
}

std::uint64_t Voxmap::Digest() const {
  // places of all chunks that are not beyond, sorted so that the order of building does not show
  struct Place {
    std::uint64_t code;
    std::uint32_t plane;
    bool operator<(const Place& other) const { return code < other.code; }
  };
  Hash64 hash;
  const std::size_t run = 4 * header().bits;  // bytes: 32 marks, four rows of a layer
  std::vector<std::uint8_t> marks(kVoxelsPerChunk / 8 * header().bits);
  for (const Field field : kAllFields) {
    std::vector<Place> places;
    const auto& size = header().size;
    for (std::uint32_t z = 0; z < size[2]; ++z) {
      for (std::uint32_t y = 0; y < size[1]; ++y) {
        for (std::uint32_t x = 0; x < size[0]; ++x) {
          const GridIndex hyperchunk{static_cast<std::int32_t>(x), static_cast<std::int32_t>(y),
                                     static_cast<std::int32_t>(z)};
          if (index()[IndexOf(hyperchunk)] == kRecordFar) continue;
          for (std::size_t c = 0; c < kChunksPerHyperchunk; ++c) {
            const GridIndex chunk = hyperchunk * kChunkSide + BlockCell(c);
            const std::uint32_t plane = PlaneOf(field, chunk);
            if (plane != kPlaneBeyond)
              places.push_back({MortonCode((origin() >> 3) + chunk), plane});
          }
        }
      }
    }
    std::sort(places.begin(), places.end());
    for (const Place& place : places) {
      hash.Add(place.code);
      for (std::size_t cell = 0; cell < kVoxelsPerChunk; cell += 32) {
        const std::uint32_t quarter = planes()[place.plane].quarters[QuarterOf(cell)];
        std::memcpy(&marks[cell / 32 * run],
                    quarters() + quarter * quarter_bytes() + CellInQuarter(cell) / 32 * run, run);
      }
      hash.AddBytes(marks.data(), marks.size());
    }
  }
  return hash.value();
}

}  // namespace tandem
