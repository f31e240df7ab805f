#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace tandem {

/// Short lists of paths that the programs remember for a person. Each list is a file in `tandem` of
/// $XDG_STATE_HOME (~/.local/state) with one path a line, the newest first.

/// Returns at most `most` paths of the list.
std::vector<std::filesystem::path> StateLines(const std::string& list, std::size_t most);

/// Puts a path first, and drops paths beyond `most`. Does nothing where it cannot write, and for a
/// path of more than one line.
void PutFirst(const std::string& list, const std::filesystem::path& path, std::size_t most);

}  // namespace tandem
