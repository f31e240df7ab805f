#include "engine/voxel/voxmap.h"

#include <algorithm>
#include <cstring>
#include <map>
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
  counts.hyperchunks = header().record_count - 2;
  counts.bytes = header().bytes;
  for (std::size_t r = 2; r < header().record_count; ++r) {
    for (std::size_t field = 0; field < kFields; ++field) {
      for (const VoxmapSlice& slice : records()[r].slices[field]) {
        const auto stored = static_cast<std::uint32_t>(std::popcount(slice.stored));
        for (std::uint32_t p = slice.first_plane; p < slice.first_plane + stored; ++p) {
          for (std::size_t cell = 0; cell < kVoxelsPerChunk; ++cell) {
            const int mark = StoredMark(p, cell);
            if (field == 1) counts.edge += mark == kSurfaceMark;
            if (field == 2) counts.vertex += mark == kSurfaceMark;
            if (field != 0) continue;
            counts.interior += mark == kInteriorMark;
            counts.surface += mark == kSurfaceMark;
            counts.free += mark > kSurfaceMark;
          }
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
      hash.AddBytes(planes() + place.plane * plane_bytes(), plane_bytes());
    }
  }
  return hash.value();
}

namespace {

struct ByPlace {
  bool operator()(const GridIndex& a, const GridIndex& b) const {
    return MortonCode(a) < MortonCode(b);
  }
};

/// The marks of one chunk out of a hyperchunk's.
std::array<Mark, kVoxelsPerChunk> ChunkOf(const std::vector<Mark>& marks, std::size_t chunk) {
  const GridIndex first = BlockCell(chunk) * kChunkSide;
  std::array<Mark, kVoxelsPerChunk> out;
  for (std::size_t cell = 0; cell < kVoxelsPerChunk; ++cell) {
    const GridIndex i = first + BlockCell(cell);
    out[cell] =
        marks[static_cast<std::size_t>(i.x + kHyperchunkSide * (i.y + kHyperchunkSide * i.z))];
  }
  return out;
}

void AppendPlane(const std::array<Mark, kVoxelsPerChunk>& marks, int bits,
                 std::vector<std::uint8_t>& planes) {
  const auto per_byte = static_cast<std::size_t>(8 / bits);
  for (std::size_t cell = 0; cell < kVoxelsPerChunk; cell += per_byte) {
    unsigned byte = 0;
    for (std::size_t k = 0; k < per_byte; ++k) {
      byte |= static_cast<unsigned>(marks[cell + k]) << (k * static_cast<std::size_t>(bits));
    }
    planes.push_back(static_cast<std::uint8_t>(byte));
  }
}

/// Whether any field has a mark in the chunk, or it is solid.
bool Bearing(const VoxmapRecord& record, std::size_t chunk) {
  const std::uint64_t bit = std::uint64_t{1} << (chunk & 63);
  std::uint64_t any = record.solid[chunk >> 6];
  for (const auto& slices : record.slices) any |= slices[chunk >> 6].stored;
  return (any & bit) != 0;
}

constexpr int kCubeSide = 3 * kChunkSide;
using ChunkCube = std::array<std::uint32_t, std::size_t{kCubeSide} * kCubeSide>;  // rows along x

std::size_t RowAt(int y, int z) {
  return static_cast<std::size_t>(y + kCubeSide * z);
}

/// By one chunk in all directions.
ChunkCube Grown(const ChunkCube& cube) {
  ChunkCube wide;
  for (int z = 0; z < kCubeSide; ++z) {
    for (int y = 0; y < kCubeSide; ++y) {
      std::uint32_t row = cube[RowAt(y, z)];
      if (y > 0) row |= cube[RowAt(y - 1, z)];
      if (y + 1 < kCubeSide) row |= cube[RowAt(y + 1, z)];
      wide[RowAt(y, z)] = row | row << 1 | row >> 1;
    }
  }
  ChunkCube out = wide;
  for (int z = 0; z < kCubeSide; ++z) {
    for (int y = 0; y < kCubeSide; ++y) {
      if (z > 0) out[RowAt(y, z)] |= wide[RowAt(y, z - 1)];
      if (z + 1 < kCubeSide) out[RowAt(y, z)] |= wide[RowAt(y, z + 1)];
    }
  }
  return out;
}

/// Gives `mark` to the chunks of the middle hyperchunk that are in the cube and have none yet.
void WriteChunkMarks(const ChunkCube& cube, int mark, VoxmapRecord& record) {
  for (std::size_t c = 0; c < kChunksPerHyperchunk; ++c) {
    const GridIndex at = BlockCell(c) + GridIndex{kChunkSide, kChunkSide, kChunkSide};
    if ((cube[RowAt(at.y, at.z)] >> at.x & 1U) == 0) continue;
    const auto shift = static_cast<int>((c & 1) * 4);
    std::uint8_t& pair = record.chunk_marks[c >> 1];
    if ((pair >> shift & 15) != 0) continue;
    pair = static_cast<std::uint8_t>(pair | mark << shift);
  }
}

}  // namespace

VoxmapBuilder::VoxmapBuilder(double voxel_size, int range, int bits)
    : voxel_size_(voxel_size), range_(range), bits_(bits) {
  TANDEM_CHECK(voxel_size > 0 && (bits == 2 || bits == 4 || bits == 8));
  TANDEM_CHECK(range >= 1 && range + 2 < (1 << bits));
}

void VoxmapBuilder::Add(const HyperchunkMarks& hyperchunk) {
  Hyperchunk& out = hyperchunks_.emplace_back();
  out.place = hyperchunk.place;
  out.solid = hyperchunk.solid;
  if (out.solid) return;
  std::uint32_t planes = 0;
  for (std::size_t field = 0; field < kFields; ++field) {
    for (std::size_t c = 0; c < kChunksPerHyperchunk; ++c) {
      VoxmapSlice& slice = out.record.slices[field][c >> 6];
      if ((c & 63) == 0) slice.first_plane = planes;
      if (hyperchunk.marks[field].empty()) continue;
      const std::array<Mark, kVoxelsPerChunk> marks = ChunkOf(hyperchunk.marks[field], c);
      const bool uniform = std::all_of(marks.begin(), marks.end(), [&](Mark mark) {
        return mark == marks[0];
      });
      const std::uint64_t bit = std::uint64_t{1} << (c & 63);
      if (uniform && marks[0] == 0) continue;
      if (uniform && marks[0] == kInteriorMark) {
        out.record.solid[c >> 6] |= bit;
        continue;
      }
      slice.stored |= bit;
      ++planes;
      AppendPlane(marks, bits_, out.planes);
    }
  }
}

Voxmap VoxmapBuilder::Finish() {
  TANDEM_CHECK(!hyperchunks_.empty());
  GridIndex lowest = hyperchunks_[0].place;
  GridIndex highest = lowest;
  for (const Hyperchunk& h : hyperchunks_) {
    const GridIndex& p = h.place;
    lowest = {std::min(lowest.x, p.x), std::min(lowest.y, p.y), std::min(lowest.z, p.z)};
    highest = {std::max(highest.x, p.x), std::max(highest.y, p.y), std::max(highest.z, p.z)};
  }
  const GridIndex border{1, 1, 1};
  const GridIndex first = lowest - border;
  const GridIndex size = highest - lowest + border * 3;

  // records: of the hyperchunks with voxels, and of their neighbours, which know how far they are
  std::map<GridIndex, const Hyperchunk*, ByPlace> near;
  for (const Hyperchunk& h : hyperchunks_) {
    for (std::size_t n = 0; n < 27; ++n) {
      const auto k = static_cast<std::int32_t>(n);
      near.emplace(h.place + GridIndex{k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1}, nullptr);
    }
  }
  std::size_t plane_count = 2;
  for (const Hyperchunk& h : hyperchunks_) {
    near[h.place] = &h;
    plane_count += h.planes.size() / (kVoxelsPerChunk / 8 * static_cast<std::size_t>(bits_));
  }

  const auto aligned = [](std::size_t bytes) {
    return (bytes + 63) / 64 * 64;
  };
  VoxmapHeader header;
  header.magic = {'t', 'a', 'n', 'd', 'e', 'm', 'V', 'M'};
  header.version = 1;
  header.bits = static_cast<std::uint32_t>(bits_);
  header.range = static_cast<std::uint32_t>(range_);
  header.voxel_size = voxel_size_;
  header.origin = {first.x * kHyperchunkSide, first.y * kHyperchunkSide, first.z * kHyperchunkSide};
  header.size = {static_cast<std::uint32_t>(size.x), static_cast<std::uint32_t>(size.y),
                 static_cast<std::uint32_t>(size.z)};
  const std::size_t cells = std::size_t{header.size[0]} * header.size[1] * header.size[2];
  const std::size_t plane_bytes = kVoxelsPerChunk / 8 * static_cast<std::size_t>(bits_);
  header.index_offset = sizeof(VoxmapHeader);
  header.records_offset = aligned(header.index_offset + cells * sizeof(std::uint32_t));
  header.record_count = 2 + near.size();
  header.planes_offset = header.records_offset + header.record_count * sizeof(VoxmapRecord);
  header.plane_count = plane_count;
  header.bytes = header.planes_offset + plane_count * plane_bytes;

  ImageBytes image(header.bytes);
  std::memcpy(image.data(), &header, sizeof header);
  auto* index = reinterpret_cast<std::uint32_t*>(image.data() + header.index_offset);
  auto* records = reinterpret_cast<VoxmapRecord*>(image.data() + header.records_offset);
  auto* planes = reinterpret_cast<std::uint8_t*>(image.data() + header.planes_offset);

  std::array<Mark, kVoxelsPerChunk> interior;
  interior.fill(kInteriorMark);
  std::vector<std::uint8_t> plane;
  AppendPlane(interior, bits_, plane);
  std::copy(plane.begin(), plane.end(), planes + kPlaneInterior * plane_bytes);

  VoxmapRecord solid;
  solid.solid.fill(~std::uint64_t{0});
  solid.chunk_marks.fill(kSurfaceMark | kSurfaceMark << 4);
  records[kRecordFar] = {};
  records[kRecordSolid] = solid;
  std::uint32_t next_record = 2;
  std::uint32_t next_plane = 2;
  const auto index_of = [&](const GridIndex& place) {
    const GridIndex i = place - first;
    return static_cast<std::size_t>(i.x) +
           header.size[0] * (static_cast<std::size_t>(i.y) +
                             std::size_t{header.size[1]} * static_cast<std::size_t>(i.z));
  };
  for (const auto& [place, content] : near) {
    if (content != nullptr && content->solid) {
      index[index_of(place)] = kRecordSolid;
      continue;
    }
    index[index_of(place)] = next_record;
    VoxmapRecord& record = records[next_record++];
    record = {};
    if (content == nullptr) continue;
    record = content->record;
    for (auto& slices : record.slices) {
      for (VoxmapSlice& slice : slices) slice.first_plane += next_plane;
    }
    std::copy(content->planes.begin(), content->planes.end(), planes + next_plane * plane_bytes);
    next_plane += static_cast<std::uint32_t>(content->planes.size() / plane_bytes);
  }

  for (const auto& [place, content] : near) {
    if (index[index_of(place)] == kRecordSolid) continue;
    // which chunks of the 3 x 3 x 3 hyperchunks round it bear marks
    ChunkCube cube{};
    for (std::int32_t n = 0; n < 27; ++n) {
      const GridIndex offset{n % 3, n / 3 % 3, n / 9};
      const GridIndex i = place - first + offset - border;
      if (i.x < 0 || i.y < 0 || i.z < 0 || i.x >= size.x || i.y >= size.y || i.z >= size.z) {
        continue;
      }
      const VoxmapRecord& other = records[index[index_of(place + offset - border)]];
      for (std::size_t c = 0; c < kChunksPerHyperchunk; ++c) {
        if (!Bearing(other, c)) continue;
        const GridIndex at = offset * kChunkSide + BlockCell(c);
        cube[RowAt(at.y, at.z)] |= 1U << at.x;
      }
    }
    VoxmapRecord& record = records[index[index_of(place)]];
    for (int distance = 0; distance <= Voxmap::kChunkRange; ++distance) {
      if (distance > 0) cube = Grown(cube);
      WriteChunkMarks(cube, kSurfaceMark + distance, record);
    }
  }
  return Voxmap(std::move(image));
}

}  // namespace tandem
