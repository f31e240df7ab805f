#pragma once

#include <filesystem>

namespace tandem {

/// Tells whether files of this kind declare their unit: 3MF, AMF, COLLADA and FBX files, by their
/// extension.
bool KindDeclaresUnit(const std::filesystem::path& file);

}  // namespace tandem
