#pragma once

#include <charconv>
#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace tandem {

/// Returns all sixteen hexadecimal digits.
inline std::string Hex(std::uint64_t value) {
  char digits[17];
  std::snprintf(digits, sizeof digits, "%016" PRIx64, value);
  return digits;
}

/// Returns the value of sixteen hexadecimal digits, or nothing for any other text.
inline std::optional<std::uint64_t> FromHex(std::string_view text) {
  std::uint64_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, fault] = std::from_chars(text.data(), end, value, 16);
  if (fault != std::errc{} || rest != end || text.size() != 16) return std::nullopt;
  return value;
}

/// Returns two hexadecimal digits for each byte.
inline std::string HexOfBytes(std::span<const std::uint8_t> bytes) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += kDigits[byte >> 4U];
    text += kDigits[byte & 15U];
  }
  return text;
}

}  // namespace tandem
