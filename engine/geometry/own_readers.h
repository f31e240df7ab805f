#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "engine/geometry/raw_mesh.h"

namespace tandem {

/// Files that the mesh library reads wrong though they are good: OFF of polygons or binary, binary
/// STL that begins with "solid" or has bytes behind its triangles, PLY, whose binary numbers may
/// look like a line's end, 3MF whose parts lie in several models. Nothing: leave the file to the
/// library. Called in the reading process.
std::optional<ReadAnswer> ReadOurselves(const std::filesystem::path& file, const std::string& part);

/// The text that the library is to read in place of the file, where it would misread the file's
/// own: UTF-16, a mark of byte order, OBJ lines that go on behind a backslash. Nothing: the file as
/// it is.
std::optional<std::string> TextInstead(const std::filesystem::path& file);

/// What is wrong with a file that the library reads without a word, leaving out or inventing
/// something: a COLLADA array of fewer numbers than it says, a number of more digits than the
/// library holds, a glTF triangle of vertices that there are not, glTF extensions and places that
/// the library takes for others. Empty: nothing. `triangles`: as many as the library found.
std::string SilentFault(const std::filesystem::path& file, std::string_view text,
                        std::size_t triangles);

/// Of an OFF file's content (Geomview's format), ASCII or binary.
ReadAnswer ReadOff(std::string_view bytes);
/// Of a binary STL file's content; nothing: it is text, or not whole.
std::optional<ReadAnswer> ReadBinaryStl(std::string_view bytes);

/// Of a PLY file's content; nothing: its head is not plain, or it has no faces.
std::optional<ReadAnswer> ReadPly(std::string_view bytes);

/// "stl", "off" …, in small letters.
std::string EndingOf(const std::filesystem::path& file);

}  // namespace tandem
