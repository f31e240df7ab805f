#pragma once

#include <filesystem>
#include <optional>

#include "engine/base/result.h"
#include "engine/voxel/map/voxmap.h"

namespace tandem {

/// Writes a map's image to a file, whole or not at all: it writes a file beside it and moves that
/// there. Returns nothing, or the error.
std::optional<Error> SaveVoxmap(const Voxmap& voxmap, const std::filesystem::path& file);

/// Maps an image from a file, read-only; its pages are read when they are first used. Errors, in
/// one line: a file that does not exist, has another kind or version, is cut short, or has an index
/// and records that point outside it.
Result<Voxmap> MapVoxmap(const std::filesystem::path& file);

}  // namespace tandem
