#pragma once

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <functional>
#include <regex>
#include <set>
#include <sstream>
#include <string>

namespace tandem::testing {

/// Returns "a claim goes back" of "at 3.217 s: a claim goes back: peer 101, left".
inline std::string SortOf(const std::string& broken) {
  const std::size_t first = broken.find("s: ") + 3;
  return broken.substr(first, broken.find(": peer", first) - first);
}

/// Names a test "fault_9_one_who_is_gone_is_still_here".
inline std::string NameOfTest(int fault, const std::string& sort) {
  std::string name = "fault_" + std::to_string(fault) + "_" + sort;
  std::ranges::replace_if(
      name,
      [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) == 0;
      },
      '_');
  return name;
}

/// Returns what `sentence` finds, group by group, in the files of a folder that `looks` names.
inline std::set<std::string> SortsIn(
    const std::filesystem::path& folder, const std::regex& sentence,
    const std::function<bool(const std::filesystem::path&)>& looks) {
  std::set<std::string> sorts;
  for (const auto& file : std::filesystem::recursive_directory_iterator(folder)) {
    if (!looks(file.path())) continue;
    std::ostringstream text;
    text << std::ifstream(file.path()).rdbuf();
    const std::string source = text.str();
    for (std::sregex_iterator at(source.begin(), source.end(), sentence), end; at != end; ++at) {
      for (std::size_t group = 1; group < at->size(); ++group) {
        if ((*at)[group].matched) sorts.insert((*at)[group]);
      }
    }
  }
  return sorts;
}

}  // namespace tandem::testing
