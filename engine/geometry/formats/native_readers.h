#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "engine/geometry/formats/raw_mesh.h"

namespace tandem {

/// Reads good files that the mesh library reads wrong: OFF of polygons or binary; binary STL that
/// begins with "solid" or has bytes behind its triangles; PLY, whose binary numbers may look like a
/// line's end; 3MF whose parts lie in several models. Returns nothing for files that are left to
/// the library. Called in the reading process.
std::optional<ReadAnswer> ReadNatively(const std::filesystem::path& file, const std::string& part);

/// Returns the text for the library in place of the file, where it would misread the file's own:
/// UTF-16, a byte-order mark, OBJ lines continued by a backslash. Returns nothing for the file as
/// it is.
std::optional<std::string> TextInstead(const std::filesystem::path& file);

/// Returns what is wrong with a file from which the library silently leaves something out or
/// invents something; empty: nothing. Examples are a COLLADA array of fewer numbers than it
/// declares, a number of more digits than the library holds, and a glTF triangle of missing
/// vertices. Others are glTF extensions and positions that the library misreads. `triangles`: the
/// number that the library found.
std::string SilentFault(const std::filesystem::path& file, std::string_view text,
                        std::size_t triangles);

/// Reads an OFF file's content (Geomview's format), ASCII or binary.
ReadAnswer ReadOff(std::string_view bytes);
/// Reads a binary STL file's content; nothing: it is text, or not whole.
std::optional<ReadAnswer> ReadBinaryStl(std::string_view bytes);

/// Reads a PLY file's content; nothing: its head is not simple, or it has no faces.
std::optional<ReadAnswer> ReadPly(std::string_view bytes);

/// Returns the extension in small letters: "stl", "off" …
std::string EndingOf(const std::filesystem::path& file);

}  // namespace tandem
