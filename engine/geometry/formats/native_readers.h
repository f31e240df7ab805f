#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "engine/geometry/formats/raw_mesh.h"

namespace tandem {

/// Reads files of the formats that this folder knows: STL, OBJ, PLY, OFF, 3MF, AMF, glTF, COLLADA.
/// Returns nothing for files that are left to the mesh library: other formats, and the first
/// versions of glTF and COLLADA. `part`: the part that is wanted; empty: all. Called in the reading
/// process.
std::optional<ReadAnswer> ReadNatively(const std::filesystem::path& file, const std::string& part);

/// Returns the text for the library in place of the file, where it would misread the file's own:
/// UTF-16, a byte-order mark. Returns nothing for the file as it is.
std::optional<std::string> TextInstead(const std::filesystem::path& file);

/// Reads an OFF file's content (Geomview's format), ASCII or binary.
ReadAnswer ReadOff(std::string_view bytes);
/// Reads an STL file's content, text or binary.
ReadAnswer ReadStl(std::string_view bytes, std::string_view part = {});
/// Reads a PLY file's content, text or binary.
ReadAnswer ReadPly(std::string_view bytes);
/// Reads an OBJ file's content.
ReadAnswer ReadObj(std::string_view text, std::string_view part = {});
/// Reads an AMF file's content, unpacked.
ReadAnswer ReadAmf(std::string_view text, std::string_view part = {});
/// Reads the content of a glTF 2 file, text or binary, and the buffers beside it; nothing: it is of
/// the first version.
std::optional<ReadAnswer> ReadGltf(std::string content, const std::filesystem::path& file,
                                   std::string_view part = {});
/// Reads the content of a COLLADA file; nothing: it is of a version before 1.4.
std::optional<ReadAnswer> ReadCollada(std::string_view text, std::string_view part = {});

/// Returns the extension in small letters: "stl", "off" …
std::string EndingOf(const std::filesystem::path& file);

}  // namespace tandem
