#include "engine/geometry/formats/native_readers.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <utility>

#include "engine/base/files/regular_file.h"
#include "engine/geometry/formats/model_3mf.h"

namespace tandem {

namespace {

constexpr std::uintmax_t kLargestRead = 4ULL << 30U;  // bytes; the reading process has less memory
constexpr std::size_t kStlHead = 84;                  // bytes: 80 of words, and the count
constexpr std::size_t kStlTriangle = 50;

ReadAnswer RefusedFile(std::string words) {
  return {ReadAnswer::Kind::kRefused, std::move(words), {}, 0};
}

/// Returns the beginning of a file.
std::string HeadOf(const std::filesystem::path& file, std::size_t most) {
  const Result<RegularFile> opened = RegularFile::Open(file);
  if (!opened) return {};
  std::string head(most, '\0');
  head.resize(opened->Read(0, head));
  return head;
}

std::uint32_t CountOf(std::string_view bytes) {
  std::uint32_t count = 0;
  if (bytes.size() >= kStlHead) std::memcpy(&count, bytes.data() + 80, sizeof count);
  return count;
}

/// Tells whether the text has neither zeros nor control bytes.
bool IsText(std::string_view head) {
  return std::ranges::none_of(head, [](char c) {
    return static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\r' && c != '\t' &&
           c != '\f' && c != '\v';
  });
}

/// Tells whether the mesh library takes a binary STL for text, or refuses it.
bool IsMisreadStl(const std::filesystem::path& file, std::uintmax_t size) {
  const std::string head = HeadOf(file, 1024);
  const std::uint32_t count = CountOf(head);
  const std::uintmax_t whole = kStlHead + std::uintmax_t{kStlTriangle} * count;
  if (count == 0 || whole > size) return false;
  const bool solid = head.find("solid") < head.find_first_not_of(" \t\r\n") + 1;
  if (!solid) return whole != size;
  // words that begin so, followed by facets, are text, whatever the number at byte 80
  return !IsText(head);
}

std::string WithoutMark(std::string text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  return text;
}

/// Converts from UTF-16 with its mark; invalid units become '?'.
std::string FromUtf16(std::string_view bytes) {
  const bool big = bytes.starts_with("\xFE\xFF");
  const auto unit = [&](std::size_t at) {
    const auto first = static_cast<unsigned char>(bytes[at]);
    const auto second = static_cast<unsigned char>(bytes[at + 1]);
    return static_cast<std::uint32_t>(big ? first << 8 | second : second << 8 | first);
  };
  std::string text;
  for (std::size_t at = 2; at + 1 < bytes.size(); at += 2) {
    std::uint32_t code = unit(at);
    if (code >= 0xD800 && code < 0xDC00 && at + 3 < bytes.size()) {
      const std::uint32_t low = unit(at + 2);
      if (low >= 0xDC00 && low < 0xE000) {
        code = 0x10000 + ((code - 0xD800) << 10U) + (low - 0xDC00);
        at += 2;
      }
    }
    if (code >= 0xD800 && code < 0xE000) code = '?';
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
  return text;
}

/// Removes a line of XML that declares another encoding than the text has here.
std::string WithoutXmlHead(std::string text) {
  if (!text.starts_with("<?xml")) return text;
  const std::size_t end = text.find("?>");
  return end == std::string::npos ? text : text.substr(end + 2);
}

/// Joins lines that end with a backslash with the next line.
std::string WithLinesJoined(const std::string& text) {
  std::string joined;
  joined.reserve(text.size());
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (text[at] == '\\') {
      const std::size_t skip = text.compare(at + 1, 2, "\r\n") == 0 ? 2
                               : text.compare(at + 1, 1, "\n") == 0 ? 1
                                                                    : 0;
      if (skip > 0) {
        joined += ' ';
        at += skip;
        continue;
      }
    }
    joined += text[at];
  }
  return joined;
}

}  // namespace

std::string EndingOf(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return ending.empty() ? ending : ending.substr(1);
}

std::optional<ReadAnswer> ReadBinaryStl(std::string_view bytes) {
  const std::uint32_t count = CountOf(bytes);
  if (count == 0 || bytes.size() - kStlHead < std::size_t{kStlTriangle} * count)
    return std::nullopt;
  ReadAnswer answer{ReadAnswer::Kind::kMesh, {}, {}, 0};
  answer.mesh.points.reserve(3 * std::size_t{count});
  answer.mesh.triangles.reserve(count);
  for (std::uint32_t t = 0; t < count; ++t) {
    // a normal, three corners, two unused bytes
    const char* corner = bytes.data() + kStlHead + std::size_t{kStlTriangle} * t + 12;
    for (int k = 0; k < 3; ++k, corner += 12) {
      FloatPoint point{};
      std::memcpy(point.data(), corner, sizeof point);
      answer.mesh.points.push_back(point);
    }
    answer.mesh.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  return answer;
}

std::optional<ReadAnswer> ReadNatively(const std::filesystem::path& file, const std::string& part) {
  const std::string ending = EndingOf(file);
  if (ending == "3mf") return ReadSeveralModels(file, part);
  const bool off = ending == "off" || ending == "coff" || ending == "noff" || ending == "cnoff";
  std::error_code unknown;
  const std::uintmax_t size = std::filesystem::file_size(file, unknown);
  const bool stl = ending == "stl" && !unknown && IsMisreadStl(file, size);
  const bool ply = ending == "ply";
  if (!off && !stl && !ply) return std::nullopt;
  Result<std::string> bytes = ReadWholeFile(file, kLargestRead);
  if (!bytes) return RefusedFile(bytes.error().what);
  std::optional<ReadAnswer> answer;
  if (off) answer = ReadOff(WithoutMark(*std::move(bytes)));
  if (stl) answer = ReadBinaryStl(*bytes);
  if (ply) answer = ReadPly(*bytes);
  if (answer && answer->kind == ReadAnswer::Kind::kMesh && !part.empty()) {
    return RefusedFile("it has no part '" + part +
                       "', for its format has none: leave \"part\" out");
  }
  return answer;
}

std::optional<std::string> TextInstead(const std::filesystem::path& file) {
  constexpr std::array<std::string_view, 6> kTexts{"obj", "dae", "stl", "ply", "gltf", "x3d"};
  const std::string ending = EndingOf(file);
  if (std::ranges::count(kTexts, ending) == 0) return std::nullopt;
  const std::string head = HeadOf(file, 3);
  const bool utf16 = head.starts_with("\xFE\xFF") || head.starts_with("\xFF\xFE");
  const bool marked = head == "\xEF\xBB\xBF";
  if (!utf16 && !marked && ending != "obj") return std::nullopt;
  Result<std::string> text = ReadWholeFile(file, kLargestRead);
  if (!text) return std::nullopt;
  const bool goes_on = ending == "obj" && text->find('\\') != std::string::npos;
  if (!utf16 && !marked && !goes_on && text->find('\0') == std::string::npos) return std::nullopt;
  std::string plain = utf16 ? WithoutXmlHead(FromUtf16(*text)) : WithoutMark(*std::move(text));
  return goes_on ? WithLinesJoined(plain) : plain;
}

}  // namespace tandem
