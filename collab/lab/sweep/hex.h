#pragma once

#include <array>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>

namespace tandem {

/// Writes the value as 16 hexadecimal digits.
inline std::string ToHex(std::uint64_t value) {
  std::array<char, 20> text{};
  std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(value));
  return text.data();
}

/// Returns the value of 16 hexadecimal digits, or nothing for any other text.
inline std::optional<std::uint64_t> FromHex(const std::string& text) {
  std::uint64_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, fault] = std::from_chars(text.data(), end, value, 16);
  if (fault != std::errc{} || rest != end || text.size() != 16) return std::nullopt;
  return value;
}

}  // namespace tandem
