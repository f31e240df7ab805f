#pragma once

#include <string>
#include <string_view>

namespace tandem {

/// Returns a stranger's text in a form for a terminal, a window and a JSON file. It is valid UTF-8
/// without control characters (C0, DEL and C1) and without marks that change the direction of
/// writing. Each other byte or character becomes a '?'.
std::string CleanText(std::string_view text);

/// Returns a text of several lines in the same form. Its line ends stay.
std::string CleanLines(std::string_view text);

}  // namespace tandem
