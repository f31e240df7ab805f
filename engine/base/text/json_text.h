#pragma once

#include <cstddef>
#include <cstdio>
#include <string>

namespace tandem {

/// Writes the control characters that JSON lets stand in a string (DEL, C1, ends of lines and marks
/// that change the direction of writing) as its escapes. A terminal shows the text without obeying
/// it, and a reader finds the same strings.
inline std::string WithControlsEscaped(const std::string& json) {
  std::string out;
  out.reserve(json.size());
  const auto byte = [&json](std::size_t i) {
    return i < json.size() ? static_cast<unsigned char>(json[i]) : 0U;
  };
  for (std::size_t at = 0; at < json.size();) {
    const unsigned first = byte(at);
    const std::size_t bytes = first < 0xC0 ? 1 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4;
    unsigned code = first;
    if (bytes == 2) code = (first & 0x1FU) << 6U | (byte(at + 1) & 0x3FU);
    if (bytes == 3) {
      code = (first & 0x0FU) << 12U | (byte(at + 1) & 0x3FU) << 6U | (byte(at + 2) & 0x3FU);
    }
    const bool obeyed =
        bytes < 4 &&
        ((code >= 0x7F && code < 0xA0) || code == 0x061C || code == 0x200E || code == 0x200F ||
         (code >= 0x2028 && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069));
    if (obeyed) {
      char escape[8];
      std::snprintf(escape, sizeof escape, "\\u%04x", code);
      out += escape;
    } else {
      out.append(json, at, bytes);
    }
    at += bytes;
  }
  return out;
}

/// Returns a JSON value as text, whatever its strings hold: bytes that are not UTF-8 are replaced
/// instead of causing an exception, and control characters are escaped. `indent`: below 0, one
/// line.
template <typename Json>
std::string JsonText(const Json& json, int indent = -1) {
  return WithControlsEscaped(json.dump(indent, ' ', false, Json::error_handler_t::replace));
}

}  // namespace tandem
