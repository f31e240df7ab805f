#pragma once

#include <map>
#include <string>
#include <vector>

namespace tandem::testing {

/// The folder whose build file adds a library, by the library's name.
using LibraryFolders = std::map<std::string, std::string>;

/// Adds the libraries that a CMakeLists.txt adds. Libraries of a folder without a place in the
/// order (engine's base) are left out: everybody may link to them.
void FindLibraries(const std::string& path, const std::string& text, LibraryFolders& folders);

/// Returns the folders that the arrows lead to or from.
std::vector<std::string> FoldersOfTheArrows();

/// Returns one line for each place in a source file that goes against the arrows of
/// docs/architecture.md, beginning with "path:line: ". `path` is relative to the top of the tree,
/// with slashes. A CMakeLists.txt is judged by the `libraries` that it names.
std::vector<std::string> ArrowViolations(const std::string& path, const std::string& text,
                                         const LibraryFolders& libraries = {});

/// Returns whether the file includes a header of assimp, which one .cpp of engine/geometry alone
/// may.
bool IncludesAssimp(const std::string& text);

}  // namespace tandem::testing
