#pragma once

#include <filesystem>
#include <optional>

namespace tandem {

/// Metres per unit as a 3MF file declares it: millimetres where it says nothing. Nothing: the file
/// is no 3MF file, or none that can be read. assimp reads the file but not this attribute. Reads
/// what strangers wrote: called in the reading process.
std::optional<double> DeclaredUnit(const std::filesystem::path& file);

}  // namespace tandem
