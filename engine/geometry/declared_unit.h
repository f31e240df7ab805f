#pragma once

#include <filesystem>
#include <optional>

namespace tandem {

/// Whether files of this kind declare their unit: 3MF files, by their ending.
bool KindDeclaresUnit(const std::filesystem::path& file);

/// Metres per unit as a 3MF file declares it: millimetres where it says nothing. Nothing: the file
/// is no 3MF file, cannot be read, or is not plain about its unit. assimp reads the file but not
/// this attribute. Reads what strangers wrote: called in the reading process.
std::optional<double> DeclaredUnit(const std::filesystem::path& file);

}  // namespace tandem
