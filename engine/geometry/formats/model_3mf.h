#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "engine/geometry/formats/raw_mesh.h"

namespace tandem {

/// Reads a 3MF file whose parts lie in several models of the archive (3MF production extension),
/// which the mesh library reads as empty. It reads objects, their components and the build, each
/// placed by its transforms. `part`: the name of an object, or Object_ID. Returns nothing if the
/// file is not of that kind. Refuses any 3MF file that is damaged, or that requires an extension
/// which is not supported.
std::optional<ReadAnswer> ReadSeveralModels(const std::filesystem::path& file,
                                            const std::string& part);

}  // namespace tandem
