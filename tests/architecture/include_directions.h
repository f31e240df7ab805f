#pragma once

#include <map>
#include <string>
#include <vector>

namespace tandem::testing {

/// The folder whose build file adds a library, by the library's name.
using LibraryFolders = std::map<std::string, std::string>;

/// Adds the libraries that a CMakeLists.txt adds. Those of no folder with a place in the order
/// (engine's base) are left out: everybody may link to them.
void FindLibraries(const std::string& path, const std::string& text, LibraryFolders& folders);

/// The folders that the arrows lead to or from.
std::vector<std::string> FoldersOfTheArrows();

/// What in a source file goes against the arrows of docs/architecture.md, one line each, beginning
/// with "path:line: ". `path` is relative to the top of the tree, with slashes. For a
/// CMakeLists.txt the arrows are those of the `libraries` that it names.
std::vector<std::string> ArrowViolations(const std::string& path, const std::string& text,
                                         const LibraryFolders& libraries = {});

/// Whether the file includes a header of assimp, which one .cpp of engine/geometry alone may.
bool IncludesAssimp(const std::string& text);

}  // namespace tandem::testing
