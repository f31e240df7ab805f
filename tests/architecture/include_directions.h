#pragma once

#include <string>
#include <vector>

namespace tandem::testing {

/// What in a source file goes against the arrows of docs/architecture.md, one line each, beginning
/// with "path:line: ". `path` is relative to the top of the tree, with slashes. For a
/// CMakeLists.txt the arrows are those of its target_link_libraries.
std::vector<std::string> ArrowViolations(const std::string& path, const std::string& text);

/// Whether the file includes a header of assimp, which one .cpp of engine/geometry alone may.
bool IncludesAssimp(const std::string& text);

}  // namespace tandem::testing
