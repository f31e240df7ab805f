#include "app/common/poses_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>

#include "engine/base/files/regular_file.h"
#include "engine/base/text/csv_text.h"

namespace tandem {

namespace {

constexpr std::size_t kLongestLine = 1 << 16;  // bytes
constexpr std::size_t kLongestCell = 256;      // bytes, text of a cell
constexpr std::size_t kMostPoses = 1'000'000;  // about 150 bytes in memory each
constexpr double kMostOfCell = 1e9;            // either sign: places in the file's unit, degrees
constexpr double kLeastAxis = 1e-9;
constexpr double kMostAxis = 1e9;

std::vector<std::string> CellsOf(std::string line) {
  if (!line.empty() && line.back() == '\r') line.pop_back();
  std::vector<std::string> cells;
  std::size_t begin = 0;
  while (true) {
    const std::size_t end = line.find(',', begin);
    cells.push_back(line.substr(begin, end == std::string::npos ? end : end - begin));
    if (end == std::string::npos) return cells;
    begin = end + 1;
  }
}

std::optional<double> NumberIn(const std::string& cell) {
  double value = 0;
  const char* const end = cell.data() + cell.size();
  const auto [stop, error] = std::from_chars(cell.data(), end, value);
  if (error != std::errc{} || stop != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// Returns a name without the ' that CsvText() puts before what a spreadsheet would run.
std::string NameIn(const std::string& cell) {
  if (!cell.starts_with('\'')) return cell;
  const std::string name = cell.substr(1);
  return CsvText(name) == cell ? name : cell;
}

constexpr std::array<const char*, 9> kColumns{"fixed", "moving", "tx", "ty",       "tz",
                                              "ax",    "ay",     "az", "angle_deg"};

bool IsColumn(const std::string& name) {
  return name == "kind" || name == "t_s" || std::ranges::count(kColumns, name) > 0;
}

}  // namespace

Result<std::vector<FilePose>> ReadPosesFile(const std::filesystem::path& file) {
  Result<RegularFile> opened = RegularFile::Open(file);
  if (!opened) return opened.error();
  LineReader lines(*std::move(opened), kLongestLine);
  const Error too_long{file.string() + ": has a line of more than " + std::to_string(kLongestLine) +
                       " bytes, so it is not a poses file"};
  std::string line;
  if (!lines.Next(line)) return lines.too_long() ? too_long : Error{file.string() + ": is empty"};
  std::map<std::string, std::size_t> place;
  const std::vector<std::string> names = CellsOf(line);
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!place.emplace(names[i], i).second && IsColumn(names[i])) {
      return Error{file.string() + ":1: has the column " + names[i] +
                   " twice: leave one of them out"};
    }
  }
  for (std::size_t k = 1; k < kColumns.size(); ++k) {
    const char* column = kColumns[k];
    if (!place.contains(column)) {
      std::string all;
      for (std::size_t i = 1; i < kColumns.size(); ++i) {
        all += (all.empty() ? "" : ",") + std::string(kColumns[i]);
      }
      return Error{file.string() + ":1: has no column " + column + "; needed are " + all};
    }
  }
  std::vector<FilePose> poses;
  for (std::size_t number = 2; lines.Next(line); ++number) {
    if (poses.size() == kMostPoses) {
      return Error{file.string() + ": more than " + std::to_string(kMostPoses) +
                   " poses: split it into several files"};
    }
    if (line.empty() || line == "\r") continue;
    const std::vector<std::string> cells = CellsOf(line);
    const std::string at = file.string() + ":" + std::to_string(number) + ": ";
    if (cells.size() != names.size()) {
      return Error{at + "expected " + std::to_string(names.size()) + " cells, got " +
                   std::to_string(cells.size())};
    }
    for (const char* column : {"fixed", "moving", "kind"}) {
      const auto named = place.find(column);
      if (named == place.end()) continue;
      const std::string& cell = cells[named->second];
      if (cell.size() > kLongestCell || !IsPlainText(cell)) {
        return Error{at + column + ": expected plain text of at most " +
                     std::to_string(kLongestCell) + " bytes, got \"" + PlainLine(cell, 60) + "\""};
      }
    }
    std::array<double, 7> values{};
    for (std::size_t k = 0; k < values.size(); ++k) {
      const std::string& cell = cells[place[kColumns[k + 2]]];
      const std::optional<double> value = NumberIn(cell);
      if (!value) {
        return Error{at + kColumns[k + 2] + ": expected a number, got \"" + PlainLine(cell, 60) +
                     "\""};
      }
      values[k] = *value;
      const bool of_axis = k >= 3 && k < 6;  // the axis's length is looked at below
      if (!of_axis && std::abs(values[k]) > kMostOfCell) {
        return Error{at + kColumns[k + 2] + ": expected a number from -1e9 to 1e9, got \"" +
                     PlainLine(cell, 60) + "\""};
      }
    }
    std::optional<double> t_s;
    if (place.contains("t_s")) {
      const std::string& cell = cells[place["t_s"]];
      t_s = NumberIn(cell);
      if (!t_s) return Error{at + "t_s: expected a number, got \"" + PlainLine(cell, 60) + "\""};
    }
    const Vec3 axis(values[3], values[4], values[5]);
    const double angle = values[6] * M_PI / 180.0;
    const double length = axis.stableNorm();
    if (angle != 0 && !(length >= kLeastAxis && length <= kMostAxis)) {
      return Error{at + "the rotation axis must have a length from 1e-9 to 1e9"};
    }
    const Vec3 turn = angle == 0 ? Vec3(Vec3::Zero()) : Vec3(angle * axis.normalized());
    poses.push_back(
        {.row = poses.size(),
         .fixed = place.contains("fixed") ? NameIn(cells[place["fixed"]]) : std::string(),
         .moving = NameIn(cells[place["moving"]]),
         .kind = place.contains("kind") ? cells[place["kind"]] : std::string(),
         .X_WM = {RotationBy(turn), Vec3(values[0], values[1], values[2])},
         .t_s = t_s});
  }
  if (lines.too_long()) return too_long;
  return poses;
}

std::string SecondsText(double t_s) {
  char text[40];
  std::snprintf(text, sizeof text, "%.6f", t_s);
  std::string seconds = text;
  seconds.erase(std::max(seconds.find_last_not_of('0'), seconds.find('.') + 3) + 1);
  return seconds;
}

}  // namespace tandem
