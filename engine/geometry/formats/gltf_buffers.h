#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/base/result.h"

namespace tandem {

/// Returns the file that a buffer's URI names: beside the glTF file or below, its percent codes
/// resolved. The error is one line.
Result<std::filesystem::path> GltfBufferFile(const std::filesystem::path& file,
                                             const std::string& uri);

/// Returns the files beside a glTF file that hold its numbers, as its `buffers` name them, each
/// once. It recognizes a glTF file by its content, as the mesh library does. Any other file has
/// none. The error is one line: a buffer lies outside of the mesh's folder, there are too many, or
/// the file cannot be read.
Result<std::vector<std::filesystem::path>> GltfBuffers(const std::filesystem::path& file);

}  // namespace tandem
