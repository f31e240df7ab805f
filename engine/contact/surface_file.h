#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>

#include "engine/base/result.h"
#include "engine/contact/surface_builder.h"

namespace tandem {

/// A surface in a file, which programs map into memory:
///
///   header   | what the file is, and of what it was made
///   field    | a block as field_image.h draws it
///   features | a block as feature_image.h draws it
///
/// Each block begins on a cache line. Bytes between them are 0. The same mesh and options give the
/// same bytes.
struct SurfaceFileHeader {
  std::array<char, 8> magic{};
  std::uint32_t version = 0;
  std::uint32_t unused = 0;
  std::uint64_t bytes = 0;     // of the whole file
  std::uint64_t checksum = 0;  // of all other bytes
  std::uint64_t mesh = 0;      // SurfaceKey
  std::uint64_t settings = 0;
  double voxel_size = 0;  // m
  std::uint64_t field_bytes = 0;
  std::uint64_t feature_bytes = 0;
};
static_assert(sizeof(SurfaceFileHeader) == 72);

/// Grows by one when the same mesh and options come to other bytes: by another format, or by other
/// rules of how a surface is made.
inline constexpr std::uint32_t kSurfaceVersion = 2;

/// What a surface was made of: the same numbers, the same surface.
struct SurfaceKey {
  std::uint64_t mesh = 0;      // of the mesh as it stands in W
  std::uint64_t settings = 0;  // of the options, and of what is fixed beside them

  bool operator==(const SurfaceKey&) const = default;
};
SurfaceKey KeyOf(const TriangleMesh& mesh_W, const SurfaceOptions& options);

/// Writes a surface of a mesh to a file, whole or not at all: a name beside it is written and then
/// moved there. Nothing, or what went wrong.
std::optional<Error> SaveSurface(const BodySurface& surface, const TriangleMesh& mesh_W,
                                 const SurfaceOptions& options, const std::filesystem::path& file);

/// Maps a mesh's surface from a file, read-only, in a body's frame that stands at X_WB. All bytes
/// are read once, so that they are in memory, where realtime_setup.h locks them. Refused in one
/// line: a file that is not there, of another kind or version, cut short, damaged, made of another
/// mesh or with other options.
Result<BodySurface> MapSurface(const std::filesystem::path& file, const TriangleMesh& mesh_W,
                               const Pose& X_WB, const SurfaceOptions& options);

/// Tells what is wrong with a file, as far as that can be told without its mesh. Nothing: all its
/// bytes are those that were saved.
std::optional<Error> SurfaceFault(const std::filesystem::path& file);

/// The checksum of a file's bytes, at least a header.
std::uint64_t SurfaceChecksum(std::span<const std::byte> file);

}  // namespace tandem
