#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/geometry/formats/native_readers.h"
#include "engine/geometry/formats/number_word.h"
#include "engine/geometry/formats/polygon_split.h"
#include "engine/geometry/formats/remark_list.h"
#include "engine/geometry/formats/text_lines.h"

namespace tandem {

namespace {

// A binary file has 80 bytes of words, the number of its triangles, and 50 bytes for each: a
// normal, three corners, two bytes of attributes. A text file has words in any case and layout:
// solid NAME, facet normal, outer loop, three vertices, endloop, endfacet, endsolid.

constexpr std::size_t kStlHead = 84;
constexpr std::size_t kStlTriangle = 50;

ReadAnswer RefusedStl(std::string words) {
  return {ReadAnswer::Kind::kRefused, "STL: " + std::move(words), {}, 0};
}

std::uint32_t CountAt(std::string_view bytes, bool swapped) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, sizeof count);
  return swapped ? __builtin_bswap32(count) : count;
}

/// Tells whether the text has neither zeros nor control bytes.
bool IsText(std::string_view head) {
  return std::ranges::none_of(head, [](char c) {
    return static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\r' && c != '\t' &&
           c != '\f' && c != '\v';
  });
}

bool IsBlank(std::string_view bytes) {
  return std::ranges::all_of(bytes, [](char c) {
    return c == '\0' || c == ' ' || c == '\n' || c == '\r' || c == '\t' || c == '\x1a';
  });
}

void AppendTriangles(std::string_view records, std::size_t count, bool swapped, RawMesh& mesh) {
  for (std::size_t t = 0; t < count; ++t) {
    const char* corner = records.data() + kStlTriangle * t + 12;
    const auto first = static_cast<std::uint32_t>(mesh.points.size());
    for (int k = 0; k < 3; ++k) {
      FilePoint point{};
      for (double& x : point) {
        std::uint32_t bits = 0;
        std::memcpy(&bits, corner, sizeof bits);
        if (swapped) bits = __builtin_bswap32(bits);
        float number = 0;
        std::memcpy(&number, &bits, sizeof number);
        x = static_cast<double>(number);
        corner += sizeof number;
      }
      mesh.points.push_back(point);
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
}

/// Returns where the words "facet normal" begin; the end: nowhere.
std::size_t FacetIn(std::string_view line) {
  const auto is_here = [&](std::size_t at, std::string_view word) {
    return InSmallLetters(line.substr(at, word.size())) == word;
  };
  for (std::size_t at = line.find_first_of("fF"); at != std::string_view::npos;
       at = line.find_first_of("fF", at + 1)) {
    if (!is_here(at, "facet")) continue;
    const std::size_t next = line.find_first_not_of(" \t", at + 5);
    if (next != std::string_view::npos && is_here(next, "normal")) return at;
  }
  return line.size();
}

/// Reads several binary files that stand one behind the other; false: they do not fill the bytes.
bool AppendInARow(std::string_view bytes, RawMesh& mesh) {
  std::vector<std::pair<std::string_view, std::size_t>> solids;
  while (!IsBlank(bytes)) {
    if (bytes.size() < kStlHead) return false;
    const std::size_t count = CountAt(bytes, false);
    if (count == 0 || (bytes.size() - kStlHead) / kStlTriangle < count) return false;
    solids.emplace_back(bytes.substr(kStlHead), count);
    bytes.remove_prefix(kStlHead + kStlTriangle * count);
  }
  for (const auto& [records, count] : solids) AppendTriangles(records, count, false, mesh);
  return true;
}

ReadAnswer ReadBinary(std::string_view bytes) {
  if (bytes.size() < kStlHead) {
    return RefusedStl("it is neither text nor as long as the head of a binary file: it is damaged");
  }
  ReadAnswer answer{ReadAnswer::Kind::kMesh, {}, {}, 0};
  answer.single_precision = true;
  const std::string_view records = bytes.substr(kStlHead);
  const std::size_t held = records.size() / kStlTriangle;
  const bool filled = records.size() % kStlTriangle == 0;
  const std::size_t said = CountAt(bytes, false);
  const std::size_t swapped = CountAt(bytes, true);
  const auto more = [&](std::size_t read) {
    return "its head says that it has " + std::to_string(said) + " triangles, and its length is " +
           "that of " + std::to_string(held) + ": " + std::to_string(read) + " are read";
  };
  if (said == held && filled) {
    AppendTriangles(records, said, false, answer.mesh);
  } else if (swapped == held && filled && held > 0) {
    AppendTriangles(records, held, true, answer.mesh);
  } else if ((said == 0 || said == 0xffffffff) && held > 0 && !IsBlank(records)) {
    // programs that write as they go do not know the number
    AppendTriangles(records, held, false, answer.mesh);
    answer.remarks.push_back(more(held));
  } else if (said > held) {
    return RefusedStl("its head says that it has " + std::to_string(said) +
                      " triangles, and its length is that of " + std::to_string(held) +
                      ": it is cut short, or its count is wrong; export it again");
  } else if (const std::string_view rest = records.substr(kStlTriangle * said); IsBlank(rest)) {
    AppendTriangles(records, said, false, answer.mesh);
  } else if (AppendInARow(bytes, answer.mesh)) {
  } else if (filled) {
    AppendTriangles(records, held, false, answer.mesh);
    answer.remarks.push_back(more(held));
  } else {
    AppendTriangles(records, said, false, answer.mesh);
    answer.remarks.push_back(std::to_string(rest.size()) +
                             " bytes behind its triangles are not read");
  }
  return answer;
}

/// Reads a text file word by word.
class StlText {
 public:
  StlText(std::string_view text, std::string_view part) : lines_(text), part_(part) {}

  ReadAnswer Read() {
    while (fault_.empty() && Line()) {
      while (fault_.empty()) {
        const std::string word = InSmallLetters(TakeWord(line_));
        if (word.empty()) break;
        Take(word);
      }
    }
    if (fault_.empty() && state_ >= State::kInFacet) {
      fault_ = "it ends within facet " + std::to_string(facets_ + 1) + ": it is cut short";
    }
    if (fault_.empty() && !part_.empty() && !found_) fault_ = NoPartWords(part_, names_);
    if (!fault_.empty()) return RefusedStl(std::move(fault_));
    if (state_ == State::kInSolid) {
      remarks_.Say("it has no endsolid behind facet " + std::to_string(facets_) +
                   ": it may be cut short");
    }
    answer_.remarks = remarks_.Lines();
    return std::move(answer_);
  }

 private:
  enum class State { kOutside, kInSolid, kInFacet, kInLoop };

  bool Line() { return lines_.Next(line_); }

  void Fault(const std::string& why) {
    if (fault_.empty()) fault_ = "line " + std::to_string(lines_.number()) + ": " + why;
  }

  void Take(const std::string& word) {
    if (word == "solid") return TakeName();
    if (word == "facet" || word == "facetnormal") return BeginFacet(word);
    if (word == "outer" || word == "outerloop" || word == "loop") {
      if (state_ < State::kInFacet) return Fault("a loop stands in no facet");
      if (state_ == State::kInFacet && !corners_.empty()) {
        return Fault("a facet has several loops: export it as triangles");
      }
      state_ = State::kInLoop;
      return;
    }
    if (word == "vertex") return TakeVertex();
    if (word == "endloop") {
      if (state_ != State::kInLoop) return Fault("a loop ends that did not begin");
      state_ = State::kInFacet;
      return;
    }
    if (word == "endfacet") return EndFacet();
    if (word == "endsolid") {
      if (state_ >= State::kInFacet) return Fault("a solid ends within a facet");
      state_ = State::kOutside;
      return SkipNameOfEnd();
    }
    if (word == "end") {  // "end loop"
      const std::string what = InSmallLetters(TakeWord(line_));
      if (!what.empty()) return Take("end" + what);
    }
    if (word == "normal" && state_ == State::kInFacet) return SkipNormal();
    if (word == "end_of_file" || IsBlank(word)) return;
    if (word.starts_with('#') || word.starts_with("//") || word.starts_with(';')) {
      line_ = {};  // a remark up to the line's end
      return;
    }
    if (state_ >= State::kInFacet) return Fault("'" + word.substr(0, 40) + "' stands in a facet");
    remarks_.Count("line that is no statement of the format",
                   "lines that are no statements of the format",
                   "left out, the first with '" + word.substr(0, 40) + "'");
    line_ = {};
  }

  /// Skips the name behind an endsolid: all of the line, or up to a solid or facet that goes on.
  void SkipNameOfEnd() {
    const std::size_t facet = FacetIn(line_);
    if (facet == line_.size()) {
      line_ = {};
      return;
    }
    std::string_view rest = line_.substr(0, facet);
    std::string_view here = rest;
    while (!here.empty()) {
      rest = here;
      if (InSmallLetters(TakeWord(here)) == "solid") break;
      rest = here;
    }
    line_.remove_prefix(facet - rest.size());
  }

  /// Takes a name, which may hold any words up to the line's end, or to a facet on the same line.
  void TakeName() {
    if (state_ >= State::kInFacet) return Fault("a solid begins within a facet");
    const std::size_t end = FacetIn(line_);
    std::string_view name = line_.substr(0, end);
    line_.remove_prefix(end);
    name.remove_prefix(std::min(name.find_first_not_of(" \t"), name.size()));
    name = name.substr(0, name.find_last_not_of(" \t") + 1);
    if (!name.empty()) names_.emplace_back(name);
    wanted_ = part_.empty() || name == part_;
    found_ = found_ || wanted_;
    state_ = State::kInSolid;
  }

  void BeginFacet(const std::string& word) {
    if (state_ >= State::kInFacet) return Fault("a facet begins within another");
    state_ = State::kInFacet;
    corners_.clear();
    std::string_view rest = line_;
    if (word == "facetnormal" || InSmallLetters(TakeWord(rest)) != "normal") SkipNormal();
  }

  /// Skips the normal, which follows from the corners and may be no numbers at all.
  void SkipNormal() {
    std::string_view rest = line_;
    for (int k = 0; k < 3; ++k) {
      const std::string word = InSmallLetters(TakeWord(rest));
      if (word == "outer" || word == "outerloop" || word == "vertex") break;
      if (word == "normal") --k;
      line_ = rest;
      if (word.empty()) break;
    }
  }

  void TakeVertex() {
    if (state_ != State::kInLoop) return Fault("a vertex stands in no loop");
    FilePoint point{};
    for (double& x : point) {
      std::string_view word = TakeWord(line_);
      while (word.empty() && Line()) word = TakeWord(line_);
      if (word.empty()) return Fault("a vertex has fewer than three numbers");
      if (!ParseNumber(word, x)) return Fault(NoNumberWords(word));
    }
    const auto at = static_cast<std::uint32_t>(answer_.mesh.points.size());
    if (wanted_) answer_.mesh.points.push_back(point);
    corners_.push_back(at);
  }

  void EndFacet() {
    if (state_ != State::kInFacet) return Fault("a facet ends that did not begin");
    if (corners_.size() < 3) {
      return Fault("a facet has " + std::to_string(corners_.size()) +
                   " vertices in place of three");
    }
    if (wanted_) SplitPolygon(answer_.mesh.points, corners_, answer_.mesh.triangles);
    ++facets_;
    state_ = State::kInSolid;
  }

  TextLines lines_;
  std::string_view part_;
  std::string_view line_;
  State state_ = State::kOutside;
  bool wanted_ = true;
  bool found_ = false;
  std::size_t facets_ = 0;
  std::vector<std::uint32_t> corners_;
  std::vector<std::string> names_;
  std::string fault_;
  RemarkList remarks_;
  ReadAnswer answer_{ReadAnswer::Kind::kMesh, {}, {}, 0};
};

/// Tells whether the bytes are a text file: they begin so, and hold no bytes of numbers.
bool IsTextFile(std::string_view bytes) {
  constexpr std::size_t kHead = 1024;
  // some programs end a text as files of DOS end
  while (bytes.ends_with('\x1a') || bytes.ends_with('\0')) bytes.remove_suffix(1);
  const std::string_view head = bytes.substr(0, kHead);
  if (!IsText(head)) return false;
  const std::size_t begin = head.find_first_not_of(" \t\r\n\f\v");
  if (begin == std::string_view::npos) return false;
  const std::string words = InSmallLetters(head.substr(begin));
  return words.starts_with("solid") || words.find("facet") != std::string::npos;
}

}  // namespace

ReadAnswer ReadStl(std::string_view bytes, std::string_view part) {
  if (IsTextFile(bytes)) return StlText(bytes, part).Read();
  if (!part.empty()) {
    return RefusedStl("it has no part '" + std::string(part) +
                      "', for a binary file has none: leave \"part\" out");
  }
  return ReadBinary(bytes);
}

}  // namespace tandem
