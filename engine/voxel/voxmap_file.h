#pragma once

#include <filesystem>
#include <optional>

#include "engine/base/result.h"
#include "engine/voxel/voxmap.h"

namespace tandem {

/// Writes a map's image to a file, whole or not at all: a name beside it is written and then moved
/// there. Nothing, or what went wrong.
std::optional<Error> SaveVoxmap(const Voxmap& voxmap, const std::filesystem::path& file);

/// Maps an image from a file, read-only; its pages are read as they are first used. Refused in one
/// line: a file that is not there, of another kind or version, cut short, or whose index and
/// records point outside it.
Result<Voxmap> MapVoxmap(const std::filesystem::path& file);

}  // namespace tandem
