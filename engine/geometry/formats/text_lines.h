#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace tandem {

/// Goes through the lines of a text, which end in LF, CR LF or CR.
class TextLines {
 public:
  explicit TextLines(std::string_view text) : rest_(text) {}

  /// Takes the next line without its end; false: there is none.
  bool Next(std::string_view& line) {
    if (rest_.empty()) return false;
    const std::size_t end = std::min(rest_.find_first_of("\r\n"), rest_.size());
    line = rest_.substr(0, end);
    const std::size_t skip = rest_.compare(end, 2, "\r\n") == 0 ? 2 : 1;
    rest_.remove_prefix(std::min(end + skip, rest_.size()));
    ++number_;
    return true;
  }
  /// Returns the number of the last line taken, from 1.
  std::size_t number() const noexcept { return number_; }
  std::string_view rest() const noexcept { return rest_; }

 private:
  std::string_view rest_;
  std::size_t number_ = 0;
};

/// Takes the first word off a line; empty: there is none.
std::string_view TakeWord(std::string_view& line);

/// Returns a word in small letters.
std::string InSmallLetters(std::string_view word);

/// Returns metres per unit as a remark such as "units: mm" or "File units = inches" says; 0: it
/// says nothing of units.
double UnitOfRemark(std::string_view remark);

/// Returns metres per unit of a unit's name, as "mm" or "inches"; 0: the name is not known.
double MetresOfUnit(std::string_view name);

/// Returns a text in UTF-8 that may be in UTF-16, with its mark or as XML begins; the mark of UTF-8
/// is removed. Invalid units become '?'.
std::string InUtf8(std::string text);

/// Returns a name of which codes such as %20 stand for bytes. What is no such code stays.
std::string WithoutPercents(std::string_view name);

}  // namespace tandem
