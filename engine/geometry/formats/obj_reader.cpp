#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "engine/geometry/formats/native_readers.h"
#include "engine/geometry/formats/number_word.h"
#include "engine/geometry/formats/polygon_split.h"
#include "engine/geometry/formats/remark_list.h"
#include "engine/geometry/formats/text_lines.h"

namespace tandem {

namespace {

// Wavefront's format: a statement a line. A backslash at a line's end continues the statement on
// the next line. Remarks do not go on. Of the other statements, only vertices and faces go on
// whatever the next line is: a folder of Windows may end in a backslash, too.

/// The treatment of a statement.
enum class Statement { kVertex, kFace, kName, kIgnored, kLine, kCurve, kCall, kUnknown };

Statement StatementOf(std::string_view word) {
  using enum Statement;
  constexpr std::array<std::pair<std::string_view, Statement>, 46> kWords{{{"v", kVertex},
                                                                           {"f", kFace},
                                                                           {"fo", kFace},
                                                                           {"o", kName},
                                                                           {"g", kName},
                                                                           {"vt", kIgnored},
                                                                           {"vn", kIgnored},
                                                                           {"vp", kIgnored},
                                                                           {"s", kIgnored},
                                                                           {"mg", kIgnored},
                                                                           {"usemtl", kIgnored},
                                                                           {"mtllib", kIgnored},
                                                                           {"usemap", kIgnored},
                                                                           {"maplib", kIgnored},
                                                                           {"bevel", kIgnored},
                                                                           {"c_interp", kIgnored},
                                                                           {"d_interp", kIgnored},
                                                                           {"lod", kIgnored},
                                                                           {"shadow_obj", kIgnored},
                                                                           {"trace_obj", kIgnored},
                                                                           {"ctech", kIgnored},
                                                                           {"stech", kIgnored},
                                                                           {"cstype", kIgnored},
                                                                           {"deg", kIgnored},
                                                                           {"bmat", kIgnored},
                                                                           {"step", kIgnored},
                                                                           {"parm", kIgnored},
                                                                           {"trim", kIgnored},
                                                                           {"hole", kIgnored},
                                                                           {"scrv", kIgnored},
                                                                           {"sp", kIgnored},
                                                                           {"end", kIgnored},
                                                                           {"con", kIgnored},
                                                                           {"l", kLine},
                                                                           {"p", kLine},
                                                                           {"curv", kCurve},
                                                                           {"curv2", kCurve},
                                                                           {"surf", kCurve},
                                                                           {"bzp", kCurve},
                                                                           {"bsp", kCurve},
                                                                           {"cdp", kCurve},
                                                                           {"cdc", kCurve},
                                                                           {"patch", kCurve},
                                                                           {"res", kIgnored},
                                                                           {"call", kCall},
                                                                           {"csh", kCall}}};
  for (const auto& [known, statement] : kWords) {
    if (word == known) return statement;
  }
  return kUnknown;
}

/// Cuts a remark off a line of numbers.
std::string_view WithoutRemark(std::string_view line) {
  return line.substr(0, line.find('#'));
}

/// Tells whether the next line is a statement of its own, or none.
bool BeginsAnew(std::string_view rest) {
  std::string_view line;
  if (!TextLines(rest).Next(line)) return true;
  const std::string_view word = TakeWord(line);
  return word.empty() || word.starts_with('#') ||
         StatementOf(InSmallLetters(word)) != Statement::kUnknown;
}

class ObjReader {
 public:
  ObjReader(std::string_view text, std::string_view part) : lines_(text), part_(part) {}

  ReadAnswer Read() {
    std::string_view line;
    while (fault_.empty() && lines_.Next(line)) TakeStatement(line);
    if (fault_.empty()) MakeFaces();
    if (fault_.empty() && !part_.empty() && !found_)
      fault_ = NoPartWords(part_, {names_.begin() + 1, names_.end()});
    if (!fault_.empty()) return {ReadAnswer::Kind::kRefused, "OBJ: " + fault_, {}, 0};
    answer_.remarks = remarks_.Lines();
    return std::move(answer_);
  }

 private:
  struct Face {
    std::size_t first, count;
    std::uint32_t object, group;
    std::size_t line;
  };

  void TakeStatement(std::string_view line) {
    const std::size_t at = lines_.number();
    std::string joined;
    std::string_view rest = line;
    std::string word = InSmallLetters(TakeWord(rest));
    if (word.empty()) return;
    if (word.starts_with('#')) {
      if (const double unit = UnitOfRemark(line); unit > 0) answer_.remarked_unit = unit;
      return;
    }
    const Statement statement = StatementOf(word);
    const bool numbers = statement == Statement::kVertex || statement == Statement::kFace;
    if (GoesOn(numbers ? WithoutRemark(line) : line, numbers)) {
      joined = Joined(line, numbers);
      rest = joined;
      word = InSmallLetters(TakeWord(rest));
    }
    if (std::string why = Take(word, rest); !why.empty()) {
      fault_ = "line " + std::to_string(at) + ": " + why;
    }
  }

  /// Tells whether the next line continues this one. `numbers`: of a vertex or a face.
  bool GoesOn(std::string_view line, bool numbers) const {
    return line.ends_with('\\') && (numbers || !BeginsAnew(lines_.rest()));
  }

  /// Joins a line with those that continue it.
  std::string Joined(std::string_view line, bool numbers) {
    std::string whole;
    while (true) {
      whole.append(line.substr(0, line.size() - 1));
      whole += ' ';
      std::string_view next;
      if (!lines_.Next(next)) return whole;
      line = WithoutRemark(next);
      if (GoesOn(line, numbers)) continue;
      whole.append(line);
      return whole;
    }
  }

  std::string Take(std::string_view word, std::string_view rest) {
    switch (StatementOf(word)) {
      case Statement::kVertex:
        return TakeVertex(WithoutRemark(rest));
      case Statement::kFace:
        return TakeFace(WithoutRemark(rest));
      case Statement::kName:
        TakeName(word == "o" ? object_ : group_, rest);
        return {};
      case Statement::kLine:
        remarks_.Count("line or point element", "line and point elements",
                       "without a surface left out");
        return {};
      case Statement::kCurve:
        remarks_.Count("free-form curve or surface", "free-form curves and surfaces",
                       "left out: export them as polygons");
        return {};
      case Statement::kCall:
        remarks_.Count("call of another file", "calls of other files",
                       "left out: export all in one file");
        return {};
      case Statement::kIgnored:
        return {};
      case Statement::kUnknown:
        break;
    }
    double number = 0;
    // a number that continues no statement belongs to a face or a vertex
    if (ParseNumber(word, number)) return "begins with a number, and continues no other line";
    remarks_.Count("line that is no statement of the format",
                   "lines that are no statements of the format",
                   "left out, the first with '" + std::string(word.substr(0, 40)) + "'");
    return {};
  }

  std::string TakeVertex(std::string_view rest) {
    std::array<double, 8> numbers{};
    std::size_t count = 0;
    for (std::string_view word = TakeWord(rest); !word.empty(); word = TakeWord(rest)) {
      if (count == numbers.size()) return "a vertex has more than eight numbers";
      if (!ParseNumber(word, numbers[count++])) return NoNumberWords(word);
    }
    if (count < 3) return "a vertex has fewer than three numbers";
    if (count == 5) return "a vertex of five numbers has no meaning: give three, or a colour too";
    const bool weighted = count == 4 || count == 8;
    if (weighted && numbers[3] != 1) {
      remarks_.Count("vertex with a weight other than 1", "vertices with weights other than 1",
                     "read without it: only curves use weights");
    }
    points_.push_back({numbers[0], numbers[1], numbers[2]});
    return {};
  }

  std::string TakeFace(std::string_view rest) {
    Face face{corners_.size(), 0, object_, group_, lines_.number()};
    for (std::string_view word = TakeWord(rest); !word.empty(); word = TakeWord(rest)) {
      const std::string_view first = word.substr(0, word.find('/'));
      std::string_view others = word.substr(first.size());
      std::int64_t vertex = 0;
      bool sound = ParseNumber(first, vertex) && std::ranges::count(word, '/') <= 2;
      while (!others.empty()) {  // texture and normal
        others.remove_prefix(1);
        const std::string_view number = others.substr(0, others.find('/'));
        std::int64_t unused = 0;
        sound = sound && (number.empty() || ParseNumber(number, unused));
        others.remove_prefix(number.size());
      }
      if (!sound) return "'" + std::string(word.substr(0, 40)) + "' is not a corner of a face";
      if (vertex < 0) vertex += static_cast<std::int64_t>(points_.size()) + 1;
      if (vertex < 1) return "a vertex index is out of range: '" + std::string(first) + "'";
      corners_.push_back(vertex - 1);
      ++face.count;
    }
    if (face.count < 3) {
      remarks_.Count("face with fewer than three corners", "faces with fewer than three corners",
                     "left out");
    }
    faces_.push_back(face);
    return {};
  }

  void TakeName(std::uint32_t& current, std::string_view rest) {
    const std::size_t begin = std::min(rest.find_first_not_of(" \t"), rest.size());
    const std::size_t end = rest.find_last_not_of(" \t");
    const std::string name(rest.substr(begin, end == std::string_view::npos ? 0 : end + 1 - begin));
    const auto next = static_cast<std::uint32_t>(names_.size());
    const auto [known, is_new] = number_of_name_.emplace(name, next);
    current = known->second;
    if (!is_new) return;
    names_.push_back(name);
    wanted_.push_back(part_.empty() || name == part_ || WithoutRemarkBehind(name) == part_);
  }

  /// Returns a name without a remark that stands behind it, a blank apart.
  static std::string_view WithoutRemarkBehind(std::string_view name) {
    const std::size_t remark = name.find(" #");
    const std::size_t last = name.substr(0, remark).find_last_not_of(" \t");
    return name.substr(0, last == std::string_view::npos ? 0 : last + 1);
  }

  /// Splits the faces, when all vertices are known.
  void MakeFaces() {
    constexpr std::uint32_t kNone = ~0U;
    std::vector<std::uint32_t> place(points_.size(), kNone);
    RawMesh& mesh = answer_.mesh;
    std::vector<std::uint32_t> corners;
    for (const Face& face : faces_) {
      const bool wanted = wanted_[face.object] || wanted_[face.group];
      found_ = found_ || wanted;
      corners.clear();
      for (std::size_t k = 0; k < face.count; ++k) {
        const std::int64_t vertex = corners_[face.first + k];
        if (vertex >= static_cast<std::int64_t>(points_.size())) {
          fault_ = "line " + std::to_string(face.line) + ": vertex index " +
                   std::to_string(vertex + 1) + " is out of range: there are only " +
                   std::to_string(points_.size()) + " vertices";
          return;
        }
        if (!wanted || face.count < 3) continue;
        std::uint32_t& at = place[static_cast<std::size_t>(vertex)];
        if (at == kNone) {
          at = static_cast<std::uint32_t>(mesh.points.size());
          mesh.points.push_back(points_[static_cast<std::size_t>(vertex)]);
        }
        corners.push_back(at);
      }
      SplitPolygon(mesh.points, corners, mesh.triangles);
    }
  }

  TextLines lines_;
  std::string_view part_;
  std::vector<FilePoint> points_;
  std::vector<std::int64_t> corners_;
  std::vector<Face> faces_;
  std::vector<std::string> names_{""};
  std::vector<bool> wanted_{part_.empty()};  // by name
  std::unordered_map<std::string, std::uint32_t> number_of_name_{{"", 0}};
  std::uint32_t object_ = 0;
  std::uint32_t group_ = 0;
  bool found_ = false;
  std::string fault_;
  RemarkList remarks_;
  ReadAnswer answer_{ReadAnswer::Kind::kMesh, {}, {}, 0};
};

}  // namespace

ReadAnswer ReadObj(std::string_view text, std::string_view part) {
  if (text.find('\0') != std::string_view::npos) {
    return {ReadAnswer::Kind::kRefused,
            "OBJ: it is not text: it is damaged or of another format",
            {},
            0};
  }
  return ObjReader(text, part).Read();
}

}  // namespace tandem
