#pragma once

#include <filesystem>
#include <optional>

#include "engine/base/files/block_file.h"
#include "engine/base/result.h"
#include "engine/contact/kept/surface_builder.h"

namespace tandem {

/// A surface in a file (block_file.h): a field as in field_image.h, and features as in
/// feature_image.h. The same mesh and options give the same bytes. The version grows by one when
/// they come to give other bytes: by another format, or by other rules of how a surface is made.
inline constexpr BlockFileKind kSurfaceFile{{'t', 'a', 'n', 'd', 'e', 'm', 'S', 'F'}, 3, "surface"};

BlockFileSources KeyOf(const TriangleMesh& mesh_W, const SurfaceOptions& options);

/// Writes a surface of a mesh to a file, whole or not at all: it writes a file beside it and moves
/// that there. Returns nothing, or the error.
std::optional<Error> SaveSurface(const BodySurface& surface, const TriangleMesh& mesh_W,
                                 const SurfaceOptions& options, const std::filesystem::path& file);

/// Maps a mesh's surface from a file, in a body's frame that stands at X_WB. Errors, in one line,
/// are those of MapBlocks(), and a surface of another mesh or with other options.
Result<BodySurface> MapSurface(const std::filesystem::path& file, const TriangleMesh& mesh_W,
                               const Pose& X_WB, const SurfaceOptions& options);

/// Returns what is wrong with a file, as far as that can be told without its mesh; nothing if all
/// its bytes are those that were saved.
std::optional<Error> SurfaceFault(const std::filesystem::path& file);

}  // namespace tandem
