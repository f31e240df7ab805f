#include "engine/contact/surface_file.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <tbb/parallel_for.h>

#include "engine/base/hash.h"
#include "engine/base/image_bytes.h"
#include "engine/base/whole_file.h"
#include "engine/contact/feature_image.h"
#include "engine/field/field_builder.h"
#include "engine/field/field_image.h"

namespace tandem {

namespace {

constexpr std::array<char, 8> kMagic{'t', 'a', 'n', 'd', 'e', 'm', 'S', 'F'};

struct BlockPlaces {
  std::uint64_t field, features, bytes;
};
BlockPlaces PlacesOf(const SurfaceFileHeader& header) {
  ArrayPlaces blocks(sizeof header);
  BlockPlaces places{};
  places.field = blocks.Add(header.field_bytes, 1);
  places.features = blocks.Add(header.feature_bytes, 1);
  places.bytes = blocks.bytes();
  return places;
}

/// As Hash64, eight words at a time: a file may have gigabytes.
std::uint64_t HashOf(std::span<const std::byte> bytes) {
  constexpr std::uint64_t kPrime = 0x9e3779b97f4a7c15ULL;
  constexpr std::size_t kWords = 8;
  constexpr std::size_t kRow = kWords * sizeof(std::uint64_t);
  std::array<std::uint64_t, kWords> sums{1, 2, 3, 4, 5, 6, 7, 8};
  std::size_t at = 0;
  for (; at + kRow <= bytes.size(); at += kRow) {
    std::array<std::uint64_t, kWords> words;
    std::memcpy(words.data(), &bytes[at], kRow);
    for (std::size_t k = 0; k < kWords; ++k) {
      sums[k] = std::rotl((sums[k] ^ words[k]) * kPrime, 29);
    }
  }
  Hash64 hash;
  for (const std::uint64_t sum : sums) hash.Add(sum);
  const std::span<const std::byte> rest = bytes.subspan(at);
  hash.AddBytes(rest.data(), rest.size());
  return hash.value();
}

/// What an intact file says of itself; nothing if all is well.
std::optional<Error> FaultOf(std::span<const std::byte> image, const std::string& name,
                             SurfaceFileHeader& header) {
  if (image.size() < sizeof header) return Error{name + ": too short for a surface"};
  std::memcpy(&header, image.data(), sizeof header);
  if (header.magic != kMagic) return Error{name + ": not a surface"};
  if (header.version != kSurfaceVersion) {
    return Error{name + ": a surface of version " + std::to_string(header.version) + ", not " +
                 std::to_string(kSurfaceVersion) + "; voxelize its mesh again"};
  }
  if (header.bytes != image.size()) {
    return Error{name + ": " + std::to_string(image.size()) + " bytes of a surface of " +
                 std::to_string(header.bytes) + "; it was cut short"};
  }
  if (header.checksum != SurfaceChecksum(image) || PlacesOf(header).bytes != header.bytes) {
    return Error{name + ": a damaged surface; voxelize its mesh again"};
  }
  return std::nullopt;
}

/// A field and features of a whole image.
struct SurfaceBlocks {
  SurfaceFileHeader header;
  DistanceField field;
  BodyFeatures features;
};
Result<SurfaceBlocks> ReadBlocks(ImageBytes mapped, const std::string& name) {
  const auto image = std::make_shared<const ImageBytes>(std::move(mapped));
  const std::span<const std::byte> bytes(image->data(), image->size());
  SurfaceFileHeader header;
  if (std::optional<Error> fault = FaultOf(bytes, name, header)) return *fault;
  const BlockPlaces places = PlacesOf(header);
  std::optional<DistanceField> field =
      FieldImage::Read({image, bytes.subspan(places.field, header.field_bytes)});
  std::optional<BodyFeatures> features =
      FeatureImage::Read({image, bytes.subspan(places.features, header.feature_bytes)});
  if (!field || !features || field->voxel_size() != header.voxel_size) {
    return Error{name + ": a damaged surface; voxelize its mesh again"};
  }
  return SurfaceBlocks{header, std::move(*field), std::move(*features)};
}

}  // namespace

SurfaceKey KeyOf(const TriangleMesh& mesh_W, const SurfaceOptions& options) {
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  Hash64 mesh;
  mesh.Add(std::uint64_t{mesh_W.vertices.size()});
  mesh.Add(HashOf(std::as_bytes(std::span(mesh_W.vertices))));
  mesh.Add(HashOf(std::as_bytes(std::span(mesh_W.triangles))));
  Hash64 settings;
  settings.Add(options.voxel_size);
  settings.Add(options.flatness_voxels);
  settings.Add(options.spacing_voxels);
  settings.Add(options.band_voxels);
  settings.Add(options.range_voxels);
  return {mesh.value(), settings.value()};
}

std::uint64_t SurfaceChecksum(std::span<const std::byte> file) {
  SurfaceFileHeader header;
  std::memcpy(&header, file.data(), sizeof header);
  header.checksum = 0;
  const std::span<const std::byte> rest = file.subspan(sizeof header);
  constexpr std::size_t kPiece = 1 << 20;
  std::vector<std::uint64_t> pieces((rest.size() + kPiece - 1) / kPiece);
  tbb::parallel_for(std::size_t{0}, pieces.size(), [&](std::size_t i) {
    pieces[i] = HashOf(rest.subspan(i * kPiece, std::min(kPiece, rest.size() - i * kPiece)));
  });
  Hash64 hash;
  hash.AddBytes(&header, sizeof header);
  for (const std::uint64_t piece : pieces) hash.Add(piece);
  return hash.value();
}

std::optional<Error> SaveSurface(const BodySurface& surface, const TriangleMesh& mesh_W,
                                 const SurfaceOptions& options, const std::filesystem::path& file) {
  std::error_code code;
  const std::filesystem::file_status there = std::filesystem::status(file, code);
  if (std::filesystem::exists(there) && !std::filesystem::is_regular_file(there)) {
    return Error{file.string() + ": is not a regular file: name another"};
  }
  const SurfaceKey key = KeyOf(mesh_W, options);
  const std::span<const std::byte> field = surface.field.bytes();
  const std::span<const std::byte> features = surface.features.bytes();
  SurfaceFileHeader header{.magic = kMagic,
                           .version = kSurfaceVersion,
                           .mesh = key.mesh,
                           .settings = key.settings,
                           .voxel_size = surface.field.voxel_size(),
                           .field_bytes = field.size(),
                           .feature_bytes = features.size()};
  const BlockPlaces places = PlacesOf(header);
  header.bytes = places.bytes;
  ImageBytes image(places.bytes);
  std::memcpy(image.data(), &header, sizeof header);
  std::memcpy(image.data() + places.field, field.data(), field.size());
  std::memcpy(image.data() + places.features, features.data(), features.size());
  header.checksum = SurfaceChecksum({image.data(), image.size()});
  std::memcpy(image.data(), &header, sizeof header);

  Result<WholeFile> out = WholeFile::Create(file);
  if (!out) return out.error();
  // in pieces, since each is copied
  constexpr std::size_t kPiece = 1 << 20;
  const std::string_view bytes(reinterpret_cast<const char*>(image.data()), image.size());
  for (std::size_t at = 0; at < bytes.size(); at += kPiece) {
    if (!out->Write(bytes.substr(at, kPiece))) break;
  }
  return out->Commit();
}

Result<BodySurface> MapSurface(const std::filesystem::path& file, const TriangleMesh& mesh_W,
                               const Pose& X_WB, const SurfaceOptions& options) {
  Result<ImageBytes> mapped = ImageBytes::Map(file);
  if (!mapped) return mapped.error();
  Result<SurfaceBlocks> blocks = ReadBlocks(std::move(*mapped), file.string());
  if (!blocks) return blocks.error();
  if (SurfaceKey{blocks->header.mesh, blocks->header.settings} != KeyOf(mesh_W, options)) {
    return Error{file.string() +
                 ": a surface of another mesh, or made with other options; voxelize this one"};
  }
  return SurfaceInBody(std::move(blocks->field), std::move(blocks->features), mesh_W, X_WB);
}

std::optional<Error> SurfaceFault(const std::filesystem::path& file) {
  Result<ImageBytes> mapped = ImageBytes::Map(file);
  if (!mapped) return mapped.error();
  const Result<SurfaceBlocks> blocks = ReadBlocks(std::move(*mapped), file.string());
  if (!blocks) return blocks.error();
  return std::nullopt;
}

}  // namespace tandem
