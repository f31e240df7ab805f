#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
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
#include "engine/geometry/formats/ply_head.h"
#include "engine/geometry/formats/polygon_split.h"
#include "engine/geometry/formats/remark_list.h"
#include "engine/geometry/formats/text_lines.h"

namespace tandem {

namespace {

// The Stanford format: a head of lines that declare the elements, their number, and the numbers of
// each. Then the numbers follow, as text or binary. Vertices have x, y and z, faces a list of their
// corners. Other elements are ignored.

ReadAnswer RefusedPly(std::string words) {
  return {ReadAnswer::Kind::kRefused, "PLY: " + std::move(words), {}, 0};
}

/// Takes numbers one by one, in any notation.
class PlyNumbers {
 public:
  explicit PlyNumbers(const PlyHead& head)
      : rest_(head.body), text_(head.text), swapped_(head.swapped) {}

  double Take(PlyNumberKind kind) {
    if (text_) return TakeWord();
    switch (kind) {
      case PlyNumberKind::kInt8:
        return TakeAs<std::int8_t>();
      case PlyNumberKind::kUint8:
        return TakeAs<std::uint8_t>();
      case PlyNumberKind::kInt16:
        return TakeAs<std::int16_t>();
      case PlyNumberKind::kUint16:
        return TakeAs<std::uint16_t>();
      case PlyNumberKind::kInt32:
        return TakeAs<std::int32_t>();
      case PlyNumberKind::kUint32:
        return TakeAs<std::uint32_t>();
      case PlyNumberKind::kFloat:
        return static_cast<double>(TakeAs<float>());
      case PlyNumberKind::kDouble:
        return TakeAs<double>();
    }
    return 0;
  }
  /// Takes a count or the number of a vertex; any other value makes the file unsound.
  std::uint32_t TakeWhole(PlyNumberKind kind) {
    const double number = Take(kind);
    const bool whole = number == std::floor(number);
    if (whole && number >= 0 && number < 4294967295.0) return static_cast<std::uint32_t>(number);
    sound_ = false;
    return 0;
  }
  std::int64_t TakeSigned(PlyNumberKind kind) {
    const double number = Take(kind);
    if (number == std::floor(number) && std::abs(number) < 4294967295.0) {
      return static_cast<std::int64_t>(number);
    }
    sound_ = false;
    return 0;
  }
  /// Returns which word made the file unsound, to follow other words.
  std::string Unsound() const {
    return unsound_.empty() ? "" : " ('" + std::string(unsound_.substr(0, 40)) + "' is no number)";
  }
  bool sound() const { return sound_; }
  std::size_t left() const { return rest_.size(); }
  /// Returns what stands behind the last number, without white space round it.
  std::string_view Rest() const {
    std::string_view rest = rest_;
    rest.remove_prefix(std::min(rest.find_first_not_of(kBlank), rest.size()));
    return rest.substr(0, rest.find_last_not_of(kBlank) + 1);
  }
  /// Skips remarks that stand behind the numbers of a line, or on lines of their own.
  void SkipRemarks() {
    if (!text_) return;
    while (true) {
      const std::string_view rest =
          rest_.substr(std::min(rest_.find_first_not_of(kBlank), rest_.size()));
      const bool remark =
          std::ranges::any_of(std::array{"#", "//", "comment", "obj_info"}, [&](const char* mark) {
            return rest.starts_with(mark);
          });
      if (!remark) return;
      rest_ = rest.substr(std::min(rest.find_first_of("\r\n"), rest.size()));
    }
  }

 private:
  static constexpr std::string_view kBlank{" \t\r\n\0\x1a", 6};
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
    if (!ParseNumber(word, number)) {
      if (sound_) unsound_ = word;
      sound_ = false;
    }
    return number;
  }

  std::string_view rest_;
  std::string_view unsound_;
  bool text_;
  bool swapped_;
  bool sound_ = true;
};

struct Faces {
  std::vector<std::uint32_t> corners;  // one after the other
  std::vector<std::uint32_t> counts;
  std::vector<std::int64_t> strips;  // corners of strips, each ended by a negative number
};

bool IsCorners(const std::string& name) {
  return name == "vertex_indices" || name == "vertex_index" || name == "vertex_inds";
}

void TakeElement(const PlyElement& element, PlyNumbers& numbers, std::vector<FilePoint>& points,
                 Faces& faces) {
  const bool vertex = element.name == "vertex";
  const bool face = element.name == "face";
  if (vertex) points.emplace_back();
  for (const PlyProperty& property : element.properties) {
    if (property.count) {
      const std::uint32_t count = numbers.TakeWhole(*property.count);
      const bool corners = face && IsCorners(property.name);
      const bool strip = element.name == "tristrips" && IsCorners(property.name);
      for (std::uint32_t i = 0; i < count && numbers.sound(); ++i) {
        if (corners) {
          faces.corners.push_back(numbers.TakeWhole(property.kind));
        } else if (strip) {
          faces.strips.push_back(numbers.TakeSigned(property.kind));
        } else {
          numbers.Take(property.kind);
        }
      }
      if (corners) faces.counts.push_back(count);
      if (strip) faces.strips.push_back(-1);
      continue;
    }
    const double number = numbers.Take(property.kind);
    if (!vertex || property.name.size() != 1) continue;
    const char axis = property.name[0];
    if (axis >= 'x' && axis <= 'z') {
      points.back()[static_cast<std::size_t>(axis - 'x')] = number;
    }
  }
}

/// Returns what is missing for a surface, and notes what is left out.
std::string ElementsFault(const PlyHead& head, RemarkList& remarks) {
  std::size_t axes = 0;
  for (const PlyElement& element : head.elements) {
    if (std::ranges::count(head.elements, element.name, &PlyElement::name) > 1) {
      return "its head declares " + element.name + " twice";
    }
    bool corners = false;
    for (const PlyProperty& property : element.properties) {
      corners = corners || (property.count && IsCorners(property.name));
      const bool axis = property.name == "x" || property.name == "y" || property.name == "z";
      if (element.name == "vertex" && axis && !property.count) ++axes;
    }
    const bool surface = element.name == "face" || element.name == "tristrips";
    if (surface && element.count > 0 && !corners) {
      return "its " + element.name + " has no list vertex_indices";
    }
    constexpr std::array<std::string_view, 6> kKnown{"vertex", "face",   "tristrips",
                                                     "edge",   "camera", "material"};
    if (element.count > 0 && std::ranges::count(kKnown, std::string_view(element.name)) == 0) {
      remarks.Say("its " + std::to_string(element.count) + " of " + element.name.substr(0, 40) +
                  " are left out");
    }
  }
  return axes == 3 ? "" : "its vertices have not x, y and z";
}

/// Splits faces and strips; returns what is wrong, or nothing.
std::string MakeTriangles(const Faces& faces, RemarkList& remarks, RawMesh& mesh) {
  const auto beyond = [&](std::int64_t corner) {
    return "a face uses vertex " + std::to_string(corner) + ", but there are only " +
           std::to_string(mesh.points.size());
  };
  std::size_t at = 0;
  for (const std::uint32_t count : faces.counts) {
    if (count < 3) {
      remarks.Count("face with fewer than three corners", "faces with fewer than three corners",
                    "left out");
    }
    const std::span corners(faces.corners.data() + at, count);
    at += count;
    for (const std::uint32_t corner : corners) {
      if (corner >= mesh.points.size()) return beyond(corner);
    }
    SplitPolygon(mesh.points, corners, mesh.triangles);
  }
  std::vector<std::uint32_t> strip;
  for (const std::int64_t corner : faces.strips) {
    if (corner >= static_cast<std::int64_t>(mesh.points.size())) return beyond(corner);
    if (corner < 0) {
      strip.clear();
      continue;
    }
    strip.push_back(static_cast<std::uint32_t>(corner));
    const std::size_t n = strip.size();
    if (n < 3) continue;
    const bool odd = n % 2 == 0;
    mesh.triangles.push_back(
        {strip[n - 3], strip[odd ? n - 1 : n - 2], strip[odd ? n - 2 : n - 1]});
  }
  return {};
}

/// Tells whether the places of vertices are 32-bit numbers.
bool HasFloatPlaces(const PlyHead& head) {
  const auto vertex = std::ranges::find(head.elements, "vertex", &PlyElement::name);
  return vertex != head.elements.end() &&
         std::ranges::any_of(vertex->properties, [](const PlyProperty& property) {
           return property.name == "x" && property.kind == PlyNumberKind::kFloat;
         });
}

}  // namespace

ReadAnswer ReadPly(std::string_view bytes) {
  PlyHead head;
  if (std::string fault = ReadPlyHead(bytes, head); !fault.empty()) return RefusedPly(fault);
  ReadAnswer answer{ReadAnswer::Kind::kMesh, {}, {}, 0};
  answer.remarked_unit = head.remarked_unit;
  const auto has = [&](std::string_view name) {
    return std::ranges::count(head.elements, name, &PlyElement::name) > 0;
  };
  if (!has("vertex") || (!has("face") && !has("tristrips"))) return answer;
  RemarkList remarks;
  if (std::string fault = ElementsFault(head, remarks); !fault.empty()) return RefusedPly(fault);
  PlyNumbers numbers(head);
  numbers.SkipRemarks();
  Faces faces;
  for (const PlyElement& element : head.elements) {
    if (element.properties.empty()) continue;
    if (element.count > numbers.left()) {
      return RefusedPly("it is shorter than the " + std::to_string(element.count) + " of its " +
                        element.name + " that it says: it is damaged or cut short");
    }
    for (std::uint64_t i = 0; i < element.count; ++i) {
      TakeElement(element, numbers, answer.mesh.points, faces);
      if (!numbers.sound()) {
        return RefusedPly("number " + std::to_string(i) + " of its " + element.name +
                          " is not whole" + numbers.Unsound() + ": it is damaged or cut short");
      }
      numbers.SkipRemarks();
    }
  }
  if (std::string fault = MakeTriangles(faces, remarks, answer.mesh); !fault.empty()) {
    return RefusedPly(fault);
  }
  answer.single_precision = !head.text && HasFloatPlaces(head);
  if (const std::size_t rest = numbers.Rest().size(); rest > 0) {
    if (head.text) {
      return RefusedPly("it has more numbers than its head declares, from '" +
                        std::string(numbers.Rest().substr(0, 20)) + "' on");
    }
    remarks.Say(std::to_string(rest) + " bytes behind its numbers are not read");
  }
  answer.remarks = remarks.Lines();
  return answer;
}

}  // namespace tandem
