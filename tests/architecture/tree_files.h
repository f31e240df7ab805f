#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tandem::testing {

/// Returns the files of this tree in the order of their names, as paths from its top. Built and
/// hidden files are left out.
std::vector<std::filesystem::path> TreeFiles();

/// Returns the text of a file of this tree; empty where there is none.
std::string TreeText(const std::filesystem::path& from_top);

}  // namespace tandem::testing
