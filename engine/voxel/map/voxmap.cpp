#include "engine/voxel/map/voxmap.h"

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

Voxmap::Voxmap(ImageBlock block)
    : image_(std::move(block.image)),
      header_(reinterpret_cast<const VoxmapHeader*>(block.bytes.data())) {
  TANDEM_CHECK(block.bytes.size() >= sizeof(VoxmapHeader) && header_->bytes == block.bytes.size());
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
  struct Marks {
    std::uint8_t interior = 0;
    std::uint8_t surface = 0;
    std::uint8_t marked = 0;
  };
  std::vector<Marks> of_quarter(header().quarter_count);
  const unsigned largest = (1U << header().bits) - 1;
  for (std::size_t q = 0; q < of_quarter.size(); ++q) {
    Marks& marks = of_quarter[q];
    const std::uint8_t* bytes = quarters() + q * quarter_bytes();
    for (std::size_t i = 0; i < quarter_bytes(); ++i) {
      for (unsigned shift = 0; shift < 8; shift += header().bits) {
        const unsigned mark = bytes[i] >> shift & largest;
        marks.interior = static_cast<std::uint8_t>(marks.interior + (mark == kInteriorMark));
        marks.surface = static_cast<std::uint8_t>(marks.surface + (mark == kSurfaceMark));
        marks.marked = static_cast<std::uint8_t>(marks.marked + (mark != 0));
      }
    }
  }
  for (std::size_t r = 2; r < header().record_count; ++r) {
    for (std::size_t field = 0; field < kFields; ++field) {
      for (const VoxmapSlice& slice : records()[r].slices[field]) {
        const auto stored = static_cast<std::uint32_t>(std::popcount(slice.stored));
        for (std::uint32_t p = slice.first_plane; p < slice.first_plane + stored; ++p) {
          std::size_t surface = 0;
          for (const std::uint32_t quarter : planes()[p].quarters) {
            const Marks& marks = of_quarter[quarter];
            surface += marks.surface;
            if (field != 0) continue;
            counts.interior += marks.interior;
            counts.free += std::size_t{marks.marked} - marks.interior - marks.surface;
          }
          if (field == 0) counts.surface += surface;
          if (field == 1) counts.edge += surface;
          if (field == 2) counts.vertex += surface;
          counts.surface_chunks += field == 0 && surface > 0 ? 1U : 0U;
        }
      }
    }
  }
  return counts;
}

std::uint64_t Voxmap::Digest() const {
  // places of all chunks that are not beyond, sorted to be independent of the order of building
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
