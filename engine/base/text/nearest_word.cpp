#include "engine/base/text/nearest_word.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace tandem {

std::string_view NearestWord(std::string_view word, const std::vector<std::string_view>& words) {
  std::string_view nearest;
  std::size_t least = word.size() / 2 + 1;  // a word that is half wrong is no typing error
  for (const std::string_view candidate : words) {
    // edit distance, a row at a time
    std::vector<std::size_t> row(candidate.size() + 1);
    for (std::size_t j = 0; j < row.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= word.size(); ++i) {
      std::size_t diagonal = std::exchange(row[0], i);
      for (std::size_t j = 1; j <= candidate.size(); ++j) {
        const std::size_t change = diagonal + (word[i - 1] == candidate[j - 1] ? 0U : 1U);
        diagonal = std::exchange(row[j], std::min({change, row[j] + 1, row[j - 1] + 1}));
      }
    }
    // a word that begins with what was typed ("mass" for "mass_kg") is near too
    const bool begun = word.size() >= 3 && candidate.substr(0, word.size()) == word;
    const std::size_t distance = begun ? 1 : row.back();
    if (distance < least) {
      least = distance;
      nearest = candidate;
    }
  }
  return nearest;
}

}  // namespace tandem
