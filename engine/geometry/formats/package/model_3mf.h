#pragma once

#include <filesystem>
#include <string>

#include "engine/geometry/formats/raw_mesh.h"

namespace tandem {

/// Reads a 3MF file: objects, their components and the build, each placed by its transforms, from
/// all models of the archive (3MF production extension). Parts that a slicer marks as settings or
/// supports are left out. `part`: the name of an object, or Object_ID. Refuses a file that is
/// damaged, requires an extension which is not supported, or has a part that takes material away.
ReadAnswer Read3mf(const std::filesystem::path& file, const std::string& part);

}  // namespace tandem
