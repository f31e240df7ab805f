#pragma once

#include <filesystem>
#include <optional>

namespace tandem {

/// Tells whether files of this kind declare their unit: 3MF, AMF, COLLADA and FBX files, by their
/// extension.
bool KindDeclaresUnit(const std::filesystem::path& file);

/// Returns metres per unit as a 3MF file declares it: millimetres where it declares none. Returns
/// nothing if the file is no 3MF file, cannot be read, or has an ambiguous unit. assimp reads the
/// file but not this attribute. The file may come from an untrusted source: called in the reading
/// process.
std::optional<double> DeclaredUnit(const std::filesystem::path& file);

}  // namespace tandem
