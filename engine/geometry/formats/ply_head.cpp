#include "engine/geometry/formats/ply_head.h"

#include <array>
#include <sstream>
#include <utility>

#include "engine/geometry/formats/text_lines.h"

namespace tandem {

namespace {

std::optional<PlyNumberKind> KindNamed(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, PlyNumberKind>, 16> kNames{
      {{"char", PlyNumberKind::kInt8},
       {"int8", PlyNumberKind::kInt8},
       {"uchar", PlyNumberKind::kUint8},
       {"uint8", PlyNumberKind::kUint8},
       {"short", PlyNumberKind::kInt16},
       {"int16", PlyNumberKind::kInt16},
       {"ushort", PlyNumberKind::kUint16},
       {"uint16", PlyNumberKind::kUint16},
       {"int", PlyNumberKind::kInt32},
       {"int32", PlyNumberKind::kInt32},
       {"uint", PlyNumberKind::kUint32},
       {"uint32", PlyNumberKind::kUint32},
       {"float", PlyNumberKind::kFloat},
       {"float32", PlyNumberKind::kFloat},
       {"double", PlyNumberKind::kDouble},
       {"float64", PlyNumberKind::kDouble}}};
  for (const auto& [known, kind] : kNames) {
    if (name == known) return kind;
  }
  return std::nullopt;
}

/// Returns the word by which the lines of a head end: that behind its first word.
std::string_view LineEndOf(std::string_view bytes) {
  const std::size_t end = bytes.find_first_of("\r\n");
  if (end == std::string_view::npos) return {};
  return bytes.substr(end, bytes.compare(end, 2, "\r\n") == 0 ? 2 : 1);
}

/// Reads a line of a head that declares something; empty: it is sound.
std::string TakeDeclaration(const std::string& line, PlyHead& head) {
  std::istringstream words{line};
  std::string word;
  const std::string wrong =
      "its head has a line that is not understood: '" + line.substr(0, 60) + "'";
  words >> word;
  if (word.empty()) return {};
  if (word == "comment" || word == "obj_info") {
    if (const double unit = UnitOfRemark(line); unit > 0) head.remarked_unit = unit;
    return {};
  }
  if (word == "format") {
    words >> word;
    head.has_format = true;
    head.text = word == "ascii";
    head.swapped = word == "binary_big_endian";
    return head.text || head.swapped || word == "binary_little_endian" ? "" : wrong;
  }
  if (word == "element") {
    PlyElement element;
    if (!(words >> element.name >> element.count)) return wrong;
    head.elements.push_back(std::move(element));
    return {};
  }
  if (word != "property" || head.elements.empty() || !(words >> word)) return wrong;
  PlyProperty property;
  if (word == "list") {
    if (!(words >> word)) return wrong;
    property.count = KindNamed(word);
    if (!property.count || !(words >> word)) return wrong;
  }
  const std::optional<PlyNumberKind> kind = KindNamed(word);
  if (!kind || !(words >> property.name)) return wrong;
  property.kind = *kind;
  head.elements.back().properties.push_back(std::move(property));
  return {};
}

}  // namespace

std::string ReadPlyHead(std::string_view bytes, PlyHead& head) {
  // data may begin with bytes that look like a line's end: all lines end as the first one does
  const std::string_view line_end = LineEndOf(bytes);
  if (line_end.empty() || !bytes.starts_with("ply")) return "it does not begin with 'ply'";
  std::string_view rest = bytes;
  bool first = true;
  while (true) {
    const std::size_t end = rest.find(line_end);
    const std::size_t skip = line_end.size();
    if (end == std::string_view::npos) {
      return "its head has no end: it is damaged or cut short";
    }
    std::string line(rest.substr(0, end));
    if (line.ends_with('\r')) line.pop_back();
    rest.remove_prefix(end + skip);
    if (first) {
      first = false;
      continue;
    }
    if (line == "end_header" || line.starts_with("end_header ")) break;
    if (std::string wrong = TakeDeclaration(line, head); !wrong.empty()) return wrong;
  }
  head.body = rest;
  return head.has_format ? "" : "its head does not say whether it is text";
}

}  // namespace tandem
