#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace tandem {

/// Short lists of paths that the programs remember for a person: a file for each, in `tandem` of
/// $XDG_STATE_HOME (~/.local/state), a line for each path, the newest first.

/// Returns at most `most` of them.
std::vector<std::filesystem::path> StateLines(const std::string& list, std::size_t most);

/// Puts a path first; the last one beyond `most` goes. Does nothing where it cannot write, and for
/// a path of more than one line.
void PutFirst(const std::string& list, const std::filesystem::path& path, std::size_t most);

}  // namespace tandem
