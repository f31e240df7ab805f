#pragma once

#include <string>
#include <string_view>

namespace tandem {

/// Text of others as a terminal, a window and a JSON file may have it: valid UTF-8 without control
/// characters (C0, DEL and C1) and without marks that change the direction of writing. What is
/// neither is a '?' for each byte or character.
std::string CleanText(std::string_view text);

}  // namespace tandem
