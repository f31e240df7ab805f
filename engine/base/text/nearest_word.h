#pragma once

#include <string_view>
#include <vector>

namespace tandem {

/// Returns the word nearest to `word` by edit distance, if it is near enough for a typing error;
/// else empty.
std::string_view NearestWord(std::string_view word, const std::vector<std::string_view>& words);

}  // namespace tandem
