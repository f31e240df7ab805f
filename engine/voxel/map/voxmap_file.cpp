#include "engine/voxel/map/voxmap_file.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <system_error>

#include "engine/base/files/whole_file.h"

namespace tandem {

namespace {

/// Tells whether all arrays of an image lie within it.
bool PlacesAreSound(const VoxmapHeader& h) {
  if ((h.bits != 2 && h.bits != 4 && h.bits != 8) || h.range < 1 ||
      h.range > static_cast<unsigned>(WidestRange(static_cast<int>(h.bits))) ||
      !(h.voxel_size > 0) || !std::isfinite(h.voxel_size)) {
    return false;
  }
  constexpr std::uint64_t kMost = std::uint64_t{1} << 44U;  // prevents overflow of products
  for (const std::uint32_t size : h.size) {
    if (size == 0 || size > (1U << 20U)) return false;
  }
  // places within the image and counts up to kMost, so that no sum wraps round
  for (const std::uint64_t place :
       {h.index_offset, h.records_offset, h.quarters_offset, h.planes_offset}) {
    if (place > h.bytes) return false;
  }
  const std::uint64_t cells = std::uint64_t{h.size[0]} * h.size[1] * h.size[2];
  const std::uint64_t quarter_bytes = kVoxelsPerQuarter / 8 * h.bits;
  if (h.record_count < 2 || h.plane_count < 2 || h.record_count > kMost || h.plane_count > kMost ||
      h.quarter_count < 2 || h.quarter_count > kMost || cells > kMost ||
      h.index_offset != sizeof(VoxmapHeader) || h.records_offset % alignof(VoxmapRecord) != 0 ||
      h.quarters_offset % 64 != 0 ||
      h.records_offset < h.index_offset + cells * sizeof(std::uint32_t) ||
      h.quarters_offset < h.records_offset + h.record_count * sizeof(VoxmapRecord) ||
      h.planes_offset != h.quarters_offset + h.quarter_count * quarter_bytes ||
      h.bytes != h.planes_offset + h.plane_count * sizeof(VoxmapPlane)) {
    return false;
  }
  return true;
}

/// Tells whether the entries of all arrays name entries that there are.
bool EntriesAreSound(std::span<const std::byte> image, const VoxmapHeader& h) {
  const std::uint64_t cells = std::uint64_t{h.size[0]} * h.size[1] * h.size[2];
  const auto* index = reinterpret_cast<const std::uint32_t*>(image.data() + h.index_offset);
  for (std::uint64_t c = 0; c < cells; ++c) {
    if (index[c] >= h.record_count) return false;
  }
  const auto* records = reinterpret_cast<const VoxmapRecord*>(image.data() + h.records_offset);
  for (std::uint64_t r = 0; r < h.record_count; ++r) {
    for (const auto& slices : records[r].slices) {
      for (const VoxmapSlice& slice : slices) {
        const auto stored = static_cast<std::uint64_t>(std::popcount(slice.stored));
        if (stored != 0 && slice.first_plane + stored > h.plane_count) return false;
      }
    }
  }
  const auto* planes = reinterpret_cast<const VoxmapPlane*>(image.data() + h.planes_offset);
  for (std::uint64_t p = 0; p < h.plane_count; ++p) {
    for (const std::uint32_t quarter : planes[p].quarters) {
      if (quarter >= h.quarter_count) return false;
    }
  }
  return true;
}

/// Returns the fault of an image; nothing if it is intact.
std::optional<Error> FaultOf(std::span<const std::byte> image, const std::string& name) {
  if (image.size() < sizeof(VoxmapHeader)) return Error{name + ": too short for a voxmap"};
  VoxmapHeader h;
  std::memcpy(&h, image.data(), sizeof h);
  constexpr std::array<char, 8> kMagic{'t', 'a', 'n', 'd', 'e', 'm', 'V', 'M'};
  if (h.magic != kMagic) return Error{name + ": not a voxmap"};
  if (h.version != kVoxmapVersion) {
    return Error{name + ": a voxmap of version " + std::to_string(h.version) + ", not " +
                 std::to_string(kVoxmapVersion) + "; voxelize its mesh again"};
  }
  if (h.bytes != image.size()) {
    return Error{name + ": " + std::to_string(image.size()) + " bytes of a voxmap of " +
                 std::to_string(h.bytes) + "; it was cut short"};
  }
  if (!PlacesAreSound(h) || !EntriesAreSound(image, h)) {
    return Error{name + ": a damaged voxmap; voxelize its mesh again"};
  }
  return std::nullopt;
}

}  // namespace

std::optional<Error> SaveVoxmap(const Voxmap& voxmap, const std::filesystem::path& file) {
  if (voxmap.empty()) return Error{file.string() + ": there is no map to save"};
  std::error_code code;
  const std::filesystem::file_status there = std::filesystem::status(file, code);
  if (std::filesystem::exists(there) && !std::filesystem::is_regular_file(there)) {
    return Error{file.string() + ": is not a regular file: name another"};
  }
  Result<WholeFile> out = WholeFile::Create(file);
  if (!out) return out.error();
  // in pieces, since each is copied
  constexpr std::size_t kPiece = 1 << 20;
  const std::string_view image(reinterpret_cast<const char*>(&voxmap.header()),
                               voxmap.header().bytes);
  for (std::size_t at = 0; at < image.size(); at += kPiece) {
    if (!out->Write(image.substr(at, kPiece))) break;
  }
  return out->Commit();
}

Result<Voxmap> MapVoxmap(const std::filesystem::path& file) {
  Result<ImageBytes> image = ImageBytes::Map(file);
  if (!image) return image.error();
  if (auto fault = FaultOf({image->data(), image->size()}, file.string())) return *fault;
  return Voxmap(std::move(*image));
}

}  // namespace tandem
