#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace tandem::testing {

/// A comment of a source file. Consecutive lines of // are one comment, and so is a trailing
/// comment with the lines below it that begin in the same column.
struct SourceComment {
  std::size_t line = 0;  // number of its first line
  std::string text;      // its lines without slashes, a line break between two
};

/// Returns the comments of C++ and IDL in their order. Slashes in literals are none.
std::vector<SourceComment> CommentsOf(std::string_view source);

}  // namespace tandem::testing
