#include "engine/geometry/formats/text_lines.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

namespace tandem {

namespace {

void AppendUtf8(std::uint32_t code, std::string& text) {
  const auto put = [&text](std::uint32_t byte) {
    text += static_cast<char>(byte);
  };
  if (code < 0x80) {
    put(code);
  } else if (code < 0x800) {
    put(0xC0 | code >> 6U);
    put(0x80 | (code & 0x3FU));
  } else if (code < 0x10000) {
    put(0xE0 | code >> 12U);
    put(0x80 | (code >> 6U & 0x3FU));
    put(0x80 | (code & 0x3FU));
  } else {
    put(0xF0 | code >> 18U);
    put(0x80 | (code >> 12U & 0x3FU));
    put(0x80 | (code >> 6U & 0x3FU));
    put(0x80 | (code & 0x3FU));
  }
}

std::string FromUtf16(std::string_view bytes, bool big) {
  const auto unit = [&](std::size_t at) {
    const auto first = static_cast<unsigned char>(bytes[at]);
    const auto second = static_cast<unsigned char>(bytes[at + 1]);
    return static_cast<std::uint32_t>(big ? first << 8 | second : second << 8 | first);
  };
  std::string text;
  text.reserve(bytes.size() / 2);
  for (std::size_t at = 0; at + 1 < bytes.size(); at += 2) {
    std::uint32_t code = unit(at);
    if (code >= 0xD800 && code < 0xDC00 && at + 3 < bytes.size()) {
      const std::uint32_t low = unit(at + 2);
      if (low >= 0xDC00 && low < 0xE000) {
        code = 0x10000 + ((code - 0xD800) << 10U) + (low - 0xDC00);
        at += 2;
      }
    }
    if (code >= 0xD800 && code < 0xE000) code = '?';
    AppendUtf8(code, text);
  }
  return text;
}

}  // namespace

std::string_view TakeWord(std::string_view& line) {
  constexpr std::string_view kSpace = " \t\f\v";
  line.remove_prefix(std::min(line.find_first_not_of(kSpace), line.size()));
  const std::string_view word = line.substr(0, line.find_first_of(kSpace));
  line.remove_prefix(word.size());
  return word;
}

std::string InSmallLetters(std::string_view word) {
  std::string small(word);
  std::ranges::transform(small, small.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return small;
}

double MetresOfUnit(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, double>, 30> kNames{{{"um", 1e-6},
                                                                        {"micron", 1e-6},
                                                                        {"microns", 1e-6},
                                                                        {"micrometer", 1e-6},
                                                                        {"micrometers", 1e-6},
                                                                        {"micrometre", 1e-6},
                                                                        {"mm", 1e-3},
                                                                        {"millimeter", 1e-3},
                                                                        {"millimeters", 1e-3},
                                                                        {"millimetre", 1e-3},
                                                                        {"millimetres", 1e-3},
                                                                        {"cm", 1e-2},
                                                                        {"centimeter", 1e-2},
                                                                        {"centimeters", 1e-2},
                                                                        {"centimetre", 1e-2},
                                                                        {"centimetres", 1e-2},
                                                                        {"m", 1},
                                                                        {"meter", 1},
                                                                        {"meters", 1},
                                                                        {"metre", 1},
                                                                        {"metres", 1},
                                                                        {"in", 0.0254},
                                                                        {"inch", 0.0254},
                                                                        {"inches", 0.0254},
                                                                        {"ft", 0.3048},
                                                                        {"foot", 0.3048},
                                                                        {"feet", 0.3048},
                                                                        {"km", 1e3},
                                                                        {"kilometer", 1e3},
                                                                        {"kilometers", 1e3}}};
  const std::string small = InSmallLetters(name);
  for (const auto& [known, metres] : kNames) {
    if (small == known) return metres;
  }
  return 0;
}

double UnitOfRemark(std::string_view remark) {
  std::string words = InSmallLetters(remark);
  std::ranges::replace_if(
      words,
      [](unsigned char c) {
        return std::isalpha(c) == 0;
      },
      ' ');
  std::string_view rest = words;
  bool of_units = false;
  for (std::string_view word = TakeWord(rest); !word.empty(); word = TakeWord(rest)) {
    if (word == "unit" || word == "units") of_units = true;
    if (!of_units) continue;
    if (const double metres = MetresOfUnit(word); metres > 0 && word != "in") return metres;
  }
  return 0;
}

std::string WithoutPercents(std::string_view name) {
  const auto digit = [](char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
  };
  std::string plain;
  for (std::size_t at = 0; at < name.size(); ++at) {
    const bool code = name[at] == '%' && at + 2 < name.size() && digit(name[at + 1]) >= 0 &&
                      digit(name[at + 2]) >= 0;
    plain += code ? static_cast<char>(16 * digit(name[at + 1]) + digit(name[at + 2])) : name[at];
    if (code) at += 2;
  }
  return plain;
}

std::string InUtf8(std::string text) {
  constexpr std::string_view kLittleXml("<\0", 2);
  constexpr std::string_view kBigXml("\0<", 2);
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  if (text.starts_with("\xFE\xFF")) return FromUtf16(std::string_view(text).substr(2), true);
  if (text.starts_with("\xFF\xFE")) return FromUtf16(std::string_view(text).substr(2), false);
  if (text.starts_with(kLittleXml)) return FromUtf16(text, false);
  if (text.starts_with(kBigXml)) return FromUtf16(text, true);
  return text;
}

}  // namespace tandem
