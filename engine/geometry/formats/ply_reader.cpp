#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/geometry/formats/native_readers.h"
#include "engine/geometry/formats/number_word.h"
#include "engine/geometry/formats/polygon_split.h"

namespace tandem {

namespace {

// The Stanford format: a head of lines that declare the elements, their number, and the numbers of
// each. Then the numbers follow, as text or binary. Vertices have x, y and z, faces a list of their
// corners. Other elements are ignored.

ReadAnswer RefusedPly(std::string words) {
  return {ReadAnswer::Kind::kRefused, "PLY: " + std::move(words), {}, 0};
}

enum class NumberKind : std::uint8_t {
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kFloat,
  kDouble
};

std::optional<NumberKind> KindNamed(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, NumberKind>, 16> kNames{
      {{"char", NumberKind::kInt8},
       {"int8", NumberKind::kInt8},
       {"uchar", NumberKind::kUint8},
       {"uint8", NumberKind::kUint8},
       {"short", NumberKind::kInt16},
       {"int16", NumberKind::kInt16},
       {"ushort", NumberKind::kUint16},
       {"uint16", NumberKind::kUint16},
       {"int", NumberKind::kInt32},
       {"int32", NumberKind::kInt32},
       {"uint", NumberKind::kUint32},
       {"uint32", NumberKind::kUint32},
       {"float", NumberKind::kFloat},
       {"float32", NumberKind::kFloat},
       {"double", NumberKind::kDouble},
       {"float64", NumberKind::kDouble}}};
  for (const auto& [known, kind] : kNames) {
    if (name == known) return kind;
  }
  return std::nullopt;
}

struct Property {
  std::string name;
  NumberKind kind = NumberKind::kFloat;
  std::optional<NumberKind> count;  // type of a list's count
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

struct Head {
  bool text = false;
  bool swapped = false;  // byte order differs from this machine's
  std::vector<Element> elements;
  std::string_view body;
};

/// Reads a head; nothing: this reader does not know it.
std::optional<Head> ReadHead(std::string_view bytes) {
  Head head;
  bool has_format = false;
  // data may begin with bytes that look like a line's end: all lines end as the first one does
  const std::size_t first = bytes.find('\n');
  if (first == std::string_view::npos || !bytes.starts_with("ply")) return std::nullopt;
  std::string_view rest = bytes;
  while (true) {
    const std::size_t end = rest.find('\n');
    if (end == std::string_view::npos) return std::nullopt;
    std::istringstream words{std::string(rest.substr(0, end))};
    rest.remove_prefix(end + 1);
    std::string word;
    words >> word;
    if (word == "end_header") break;
    if (word == "format") {
      words >> word;
      has_format = true;
      head.text = word == "ascii";
      head.swapped = word == "binary_big_endian";
      if (!head.text && !head.swapped && word != "binary_little_endian") return std::nullopt;
    } else if (word == "element") {
      Element element;
      if (!(words >> element.name >> element.count)) return std::nullopt;
      head.elements.push_back(std::move(element));
    } else if (word == "property") {
      if (head.elements.empty() || !(words >> word)) return std::nullopt;
      Property property;
      if (word == "list") {
        if (!(words >> word)) return std::nullopt;
        property.count = KindNamed(word);
        if (!property.count || !(words >> word)) return std::nullopt;
      }
      const std::optional<NumberKind> kind = KindNamed(word);
      if (!kind || !(words >> property.name)) return std::nullopt;
      property.kind = *kind;
      head.elements.back().properties.push_back(std::move(property));
    }
  }
  head.body = rest;
  return has_format ? std::optional(std::move(head)) : std::nullopt;
}

/// Takes numbers one by one, in any notation.
class PlyNumbers {
 public:
  explicit PlyNumbers(const Head& head)
      : rest_(head.body), text_(head.text), swapped_(head.swapped) {}

  double Take(NumberKind kind) {
    if (text_) return TakeWord();
    switch (kind) {
      case NumberKind::kInt8:
        return TakeAs<std::int8_t>();
      case NumberKind::kUint8:
        return TakeAs<std::uint8_t>();
      case NumberKind::kInt16:
        return TakeAs<std::int16_t>();
      case NumberKind::kUint16:
        return TakeAs<std::uint16_t>();
      case NumberKind::kInt32:
        return TakeAs<std::int32_t>();
      case NumberKind::kUint32:
        return TakeAs<std::uint32_t>();
      case NumberKind::kFloat:
        return static_cast<double>(TakeAs<float>());
      case NumberKind::kDouble:
        return TakeAs<double>();
    }
    return 0;
  }
  /// Takes a count or the number of a vertex; any other value makes the file unsound.
  std::uint32_t TakeWhole(NumberKind kind) {
    const double number = Take(kind);
    if (number >= 0 && number < 4294967295.0) return static_cast<std::uint32_t>(number);
    sound_ = false;
    return 0;
  }
  bool sound() const { return sound_; }
  std::size_t left() const { return rest_.size(); }

 private:
  template <typename T>
  T TakeAs() {
    std::array<char, sizeof(T)> bytes{};
    if (rest_.size() < sizeof(T)) {
      sound_ = false;
      rest_ = {};
      return T{};
    }
    std::copy_n(rest_.data(), sizeof(T), bytes.data());
    rest_.remove_prefix(sizeof(T));
    if (swapped_) std::ranges::reverse(bytes);
    return std::bit_cast<T>(bytes);
  }
  double TakeWord() {
    const std::size_t begin = std::min(rest_.find_first_not_of(" \t\r\n"), rest_.size());
    rest_.remove_prefix(begin);
    const std::size_t end = std::min(rest_.find_first_of(" \t\r\n"), rest_.size());
    const std::string_view word = rest_.substr(0, end);
    rest_.remove_prefix(end);
    double number = 0;
    sound_ = ParseNumber(word, number) && sound_;
    return number;
  }

  std::string_view rest_;
  bool text_;
  bool swapped_;
  bool sound_ = true;
};

struct Faces {
  std::vector<std::uint32_t> corners;  // one after the other
  std::vector<std::uint32_t> counts;
};

void TakeElement(const Element& element, PlyNumbers& numbers, std::vector<FloatPoint>& points,
                 Faces& faces) {
  const bool vertex = element.name == "vertex";
  const bool face = element.name == "face";
  if (vertex) points.emplace_back();
  for (const Property& property : element.properties) {
    if (property.count) {
      const std::uint32_t count = numbers.TakeWhole(*property.count);
      const bool corners =
          face && (property.name == "vertex_indices" || property.name == "vertex_index");
      for (std::uint32_t i = 0; i < count && numbers.sound(); ++i) {
        if (corners) {
          faces.corners.push_back(numbers.TakeWhole(property.kind));
        } else {
          numbers.Take(property.kind);
        }
      }
      if (corners) faces.counts.push_back(count);
      continue;
    }
    const double number = numbers.Take(property.kind);
    if (!vertex || property.name.size() != 1) continue;
    const char axis = property.name[0];
    if (axis >= 'x' && axis <= 'z') {
      points.back()[static_cast<std::size_t>(axis - 'x')] = static_cast<float>(number);
    }
  }
}

}  // namespace

std::optional<ReadAnswer> ReadPly(std::string_view bytes) {
  // the library would search for the head's end for ever
  if (bytes.find("end_header") == std::string_view::npos) {
    return RefusedPly("its head has no end: it is damaged or cut short");
  }
  const std::optional<Head> head = ReadHead(bytes);
  if (!head) return std::nullopt;
  // strips of triangles and other forms of surfaces are left to the library
  const auto has = [&](std::string_view name) {
    return std::ranges::count(head->elements, name, &Element::name) == 1;
  };
  if (!has("vertex") || !has("face")) return std::nullopt;
  PlyNumbers numbers(*head);
  ReadAnswer answer{ReadAnswer::Kind::kMesh, {}, {}, 0};
  Faces faces;
  for (const Element& element : head->elements) {
    if (element.properties.empty()) continue;
    if (element.count > numbers.left()) {
      return RefusedPly("it is shorter than the " + std::to_string(element.count) + " of its " +
                        element.name + " that it says: it is damaged or cut short");
    }
    for (std::uint64_t i = 0; i < element.count; ++i) {
      TakeElement(element, numbers, answer.mesh.points, faces);
      if (!numbers.sound()) {
        return RefusedPly("number " + std::to_string(i) + " of its " + element.name +
                          " is not whole: it is damaged or cut short");
      }
    }
  }
  std::size_t at = 0;
  for (const std::uint32_t count : faces.counts) {
    const std::span corners(faces.corners.data() + at, count);
    at += count;
    for (const std::uint32_t corner : corners) {
      if (corner >= answer.mesh.points.size()) {
        return RefusedPly("a face uses vertex " + std::to_string(corner) + ", but there are only " +
                          std::to_string(answer.mesh.points.size()));
      }
    }
    SplitPolygon(answer.mesh.points, corners, answer.mesh.triangles);
  }
  return answer;
}

}  // namespace tandem
