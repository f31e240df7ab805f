#pragma once

#include <filesystem>
#include <optional>

#include "engine/base/block_file.h"
#include "engine/base/result.h"
#include "engine/contact/surface_builder.h"

namespace tandem {

/// A surface in a file (block_file.h): a field as field_image.h draws it, and features as
/// feature_image.h does. The same mesh and options give the same bytes. The version grows by one
/// when they come to other bytes: by another format, or by other rules of how a surface is made.
inline constexpr BlockFileKind kSurfaceFile{{'t', 'a', 'n', 'd', 'e', 'm', 'S', 'F'}, 2, "surface"};

MadeOf KeyOf(const TriangleMesh& mesh_W, const SurfaceOptions& options);

/// Writes a surface of a mesh to a file, whole or not at all: a name beside it is written and then
/// moved there. Nothing, or what went wrong.
std::optional<Error> SaveSurface(const BodySurface& surface, const TriangleMesh& mesh_W,
                                 const SurfaceOptions& options, const std::filesystem::path& file);

/// Maps a mesh's surface from a file, in a body's frame that stands at X_WB. Refused in one line:
/// what MapBlocks() refuses, and a surface of another mesh or with other options.
Result<BodySurface> MapSurface(const std::filesystem::path& file, const TriangleMesh& mesh_W,
                               const Pose& X_WB, const SurfaceOptions& options);

/// Tells what is wrong with a file, as far as that can be told without its mesh. Nothing: all its
/// bytes are those that were saved.
std::optional<Error> SurfaceFault(const std::filesystem::path& file);

}  // namespace tandem
