#pragma once

#include <algorithm>
#include <charconv>
#include <concepts>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <system_error>

namespace tandem {

/// Tells whether a number without sign that its type cannot hold is too large for it; otherwise it
/// is too small.
inline bool IsBeyondTheLargest(std::string_view word) {
  const std::size_t e = std::min(word.find_first_of("eE"), word.size());
  const std::string_view digits = word.substr(0, e);
  const auto first = static_cast<std::int64_t>(digits.find_first_of("123456789"));
  const auto point = static_cast<std::int64_t>(std::min(digits.find('.'), digits.size()));
  std::string_view power = word.substr(std::min(e + 1, word.size()));
  if (power.starts_with('+')) power.remove_prefix(1);
  std::int64_t exponent = 0;
  const auto [end, error] = std::from_chars(power.data(), power.data() + power.size(), exponent);
  if (error == std::errc::result_out_of_range) return !power.starts_with('-');
  return exponent > first - point;
}

/// Returns a Fortran number such as 2.0D-01 with an e in the place of its D; any other word as it
/// is.
inline std::string WithoutFortranExponent(std::string_view word) {
  std::string plain(word);
  const std::size_t d = plain.find_first_of("dD");
  const auto digit = [&](std::size_t at) {
    return at < plain.size() && plain[at] >= '0' && plain[at] <= '9';
  };
  if (d == std::string::npos || d == 0) return plain;
  const bool behind_number = digit(d - 1) || (plain[d - 1] == '.' && d > 1 && digit(d - 2));
  const bool signed_power = d + 1 < plain.size() && (plain[d + 1] == '+' || plain[d + 1] == '-');
  if (behind_number && digit(d + (signed_power ? 2 : 1))) plain[d] = 'e';
  return plain;
}

/// Reads the number that makes up all of `word`, with a sign of either kind, also with Fortran's
/// exponent (2.0D-01). A whole number that
/// the type cannot hold is none. A real number beyond the largest becomes infinite, for which
/// meshes are refused later; a number below the smallest becomes 0.
template <typename T>
bool ParseNumber(std::string_view word, T& number) {
  if (word.starts_with('+')) {
    word.remove_prefix(1);
    if (word.starts_with('-')) return false;
  }
  std::string fortran;
  if constexpr (std::floating_point<T>) {
    if (word.find_first_of("dD") != std::string_view::npos) {
      fortran = WithoutFortranExponent(word);
      word = fortran;
    }
  }
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (word.empty() || end != word.data() + word.size()) return false;
  if constexpr (std::floating_point<T>) {
    if (error == std::errc::result_out_of_range) {
      const bool negative = word.starts_with('-');
      number = IsBeyondTheLargest(word.substr(negative ? 1 : 0))
                   ? std::numeric_limits<T>::infinity()
                   : T{0};
      if (negative) number = -number;
      return true;
    }
  }
  return error == std::errc();
}

/// Returns why a word is no number, with what to do, for a line to the user.
inline std::string NoNumberWords(std::string_view word) {
  const std::string shown = "'" + std::string(word.substr(0, 40)) + "' is not a number";
  if (word.find(',') != std::string_view::npos) {
    return shown + ": write it with a decimal point, and without separators of thousands";
  }
  return shown + ": write it without a unit or other words behind it";
}

}  // namespace tandem
