#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "engine/geometry/formats/native_readers.h"
#include "engine/geometry/formats/number_word.h"
#include "engine/geometry/formats/polygon_split.h"
#include "engine/geometry/formats/remark_list.h"
#include "engine/geometry/formats/text_lines.h"

namespace tandem {

namespace {

// Geomview's format: a word for the numbers of a vertex, three counts, a line for each vertex and a
// line for each face. A vertex's line may have a normal and a colour behind its position. A face's
// line has its number of corners, their numbers, then perhaps a colour. Binary files have the same
// as 32-bit numbers, most significant byte first; some programs write them the other way round.

constexpr std::uint32_t kMostCorners = 100'000;  // corners of a face

ReadAnswer RefusedOff(std::string words) {
  return {ReadAnswer::Kind::kRefused, "OFF: " + std::move(words), {}, 0};
}

/// Reads [ST][C][N][4][n]OFF in letters of any size: returns the numbers of a vertex besides its
/// position; -1: another format.
int ExtrasOf(std::string_view written) {
  std::string capitals(written);
  std::ranges::transform(capitals, capitals.begin(), [](char c) {
    return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  });
  std::string_view word = capitals;
  int extras = 0;
  for (const auto& [letters, count] : {std::pair{"ST", 2}, std::pair{"C", 4}, std::pair{"N", 3}}) {
    if (!word.starts_with(letters)) continue;
    word.remove_prefix(std::string_view(letters).size());
    extras += count;
  }
  return word == "OFF" ? extras : -1;
}

/// Splits a text without comments into words, line by line.
class OffText {
 public:
  explicit OffText(std::string_view text) : rest_(text) {}

  /// Returns the next word, on any line; empty: none is left.
  std::string_view Word() {
    while (true) {
      const std::string_view word = WordOfLine();
      if (!word.empty() || !NextLine()) return word;
    }
  }
  /// Returns the next word on this line; empty: the line has no more.
  std::string_view WordOfLine() {
    const std::size_t begin = std::min(rest_.find_first_not_of(" \t\f\v"), rest_.size());
    rest_.remove_prefix(begin);
    const std::size_t end = std::min(rest_.find_first_of(" \t\r\f\v\n#"), rest_.size());
    const std::string_view word = rest_.substr(0, end);
    rest_.remove_prefix(end);
    return word;
  }
  bool NextLine() {
    const std::size_t end = rest_.find_first_of("\r\n");
    if (end == std::string_view::npos) return false;
    rest_.remove_prefix(end + (rest_.compare(end, 2, "\r\n") == 0 ? 2 : 1));
    return true;
  }
  std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
};

void CountSmallFace(std::size_t corners, RemarkList& remarks) {
  if (corners >= 3) return;
  remarks.Count("face with fewer than three corners", "faces with fewer than three corners",
                "left out");
}

/// Takes a vertex's numbers on this line; false: one of them is no number, or they are too few.
bool TakePoint(OffText& text, FilePoint& point) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (!ParseNumber(i == 0 ? text.Word() : text.WordOfLine(), point[i])) return false;
  }
  for (std::string_view word = text.WordOfLine(); !word.empty(); word = text.WordOfLine()) {
    double number = 0;
    if (!ParseNumber(word, number)) return false;  // neither a normal nor a colour
  }
  text.NextLine();
  return true;
}

/// Takes a face's numbers on this line, and skips what may stand behind them.
std::string TakeFace(OffText& text, std::uint32_t points, std::vector<std::uint32_t>& corners) {
  std::uint32_t count = 0;
  if (!ParseNumber(text.Word(), count)) return "has fewer faces than it says";
  if (count > kMostCorners) return "has a face of " + std::to_string(count) + " corners";
  corners.assign(count, 0);
  for (std::uint32_t& corner : corners) {
    if (!ParseNumber(text.Word(), corner)) return "has a face without all its corners";
    if (corner >= points) {
      return "uses vertex " + std::to_string(corner) + ", but there are only " +
             std::to_string(points);
    }
  }
  text.NextLine();  // a colour
  return {};
}

ReadAnswer ReadText(OffText text, std::size_t bytes) {
  std::array<std::uint32_t, 2> counts{};
  for (std::uint32_t& count : counts) {
    if (!ParseNumber(text.Word(), count))
      return RefusedOff("does not say how many vertices and faces it has");
  }
  text.NextLine();  // edges, which some programs leave out
  // each vertex and face takes at least a byte
  if (counts[0] > bytes || counts[1] > bytes) {
    return RefusedOff("is shorter than the vertices and faces that it says");
  }
  ReadAnswer answer{ReadAnswer::Kind::kMesh, {}, {}, 0};
  answer.mesh.points.resize(counts[0]);
  for (FilePoint& point : answer.mesh.points) {
    if (!TakePoint(text, point)) {
      return RefusedOff("has fewer vertices than it says, or one that is not three numbers");
    }
  }
  RemarkList remarks;
  std::vector<std::uint32_t> corners;
  for (std::uint32_t f = 0; f < counts[1]; ++f) {
    if (std::string fault = TakeFace(text, counts[0], corners); !fault.empty()) {
      return RefusedOff(std::move(fault));
    }
    CountSmallFace(corners.size(), remarks);
    SplitPolygon(answer.mesh.points, corners, answer.mesh.triangles);
  }
  if (!text.Word().empty()) return RefusedOff("has more lines than the vertices and faces it says");
  answer.remarks = remarks.Lines();
  return answer;
}

/// Reads 32-bit numbers in one of the two orders of bytes.
class OffNumbers {
 public:
  OffNumbers(std::string_view bytes, bool swapped) : bytes_(bytes), swapped_(swapped) {}
  std::uint32_t Whole() {
    if (bytes_.size() < 4) {
      sound_ = false;
      return 0;
    }
    std::uint32_t number = 0;
    std::memcpy(&number, bytes_.data(), sizeof number);
    bytes_.remove_prefix(4);
    return swapped_ ? __builtin_bswap32(number) : number;
  }
  float Real() { return std::bit_cast<float>(Whole()); }
  void Skip(std::size_t count) {
    sound_ = sound_ && bytes_.size() / 4 >= count;
    if (sound_) bytes_.remove_prefix(4 * count);
  }
  std::size_t left() const { return bytes_.size() / 4; }
  bool sound() const { return sound_; }

 private:
  std::string_view bytes_;
  bool swapped_;
  bool sound_ = true;
};

/// Reads a file in that order of bytes; nothing: the bytes do not fit one.
std::optional<ReadAnswer> ReadBinary(OffNumbers numbers, std::size_t extras) {
  const std::uint32_t points = numbers.Whole();
  const std::uint32_t faces = numbers.Whole();
  numbers.Whole();  // edges
  if (!numbers.sound() || points > numbers.left() / (3 + extras)) return std::nullopt;
  ReadAnswer answer{ReadAnswer::Kind::kMesh, {}, {}, 0};
  answer.single_precision = true;
  answer.mesh.points.resize(points);
  for (FilePoint& point : answer.mesh.points) {
    for (double& x : point) x = static_cast<double>(numbers.Real());
    numbers.Skip(extras);
  }
  RemarkList remarks;
  std::vector<std::uint32_t> corners;
  for (std::uint32_t f = 0; f < faces && numbers.sound(); ++f) {
    const std::uint32_t count = numbers.Whole();
    if (count > kMostCorners || count > numbers.left()) return std::nullopt;
    corners.assign(count, 0);
    for (std::uint32_t& corner : corners) {
      corner = numbers.Whole();
      if (corner >= points) return std::nullopt;
    }
    numbers.Skip(numbers.Whole());  // a colour
    CountSmallFace(count, remarks);
    SplitPolygon(answer.mesh.points, corners, answer.mesh.triangles);
  }
  if (!numbers.sound() || numbers.left() > 0) return std::nullopt;
  answer.remarks = remarks.Lines();
  return answer;
}

}  // namespace

ReadAnswer ReadOff(std::string_view bytes) {
  OffText text(bytes);
  const std::string_view word = text.Word();
  std::uint32_t number = 0;
  // the word may be left out
  if (ParseNumber(word, number)) return ReadText(OffText(bytes), bytes.size());
  const int extras = ExtrasOf(word);
  if (extras < 0)
    return RefusedOff("'" + std::string(word.substr(0, 20)) + "' is not of three dimensions");
  OffText next = text;
  if (InSmallLetters(next.WordOfLine()) != "binary") return ReadText(text, bytes.size());
  if (!next.NextLine()) return RefusedOff("ends behind its first line");
  const std::string_view numbers = next.rest();
  for (const bool swapped : {true, false}) {
    if (auto answer = ReadBinary(OffNumbers(numbers, swapped), static_cast<std::size_t>(extras))) {
      return *std::move(answer);
    }
  }
  return RefusedOff("its binary numbers are not those of a mesh: it is damaged or cut short");
}

}  // namespace tandem
