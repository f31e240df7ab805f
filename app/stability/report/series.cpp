#include "app/stability/report/series.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <set>
#include <system_error>

#include "app/picture/chart.h"
#include "engine/base/files/regular_file.h"

namespace tandem {

namespace {

constexpr std::size_t kLongestLine = 1 << 16;     // bytes
constexpr std::size_t kMostNumbers = 30'000'000;  // 240 MB of memory
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

std::vector<std::string> Split(const std::string& line) {
  std::vector<std::string> parts;
  std::size_t from = 0;
  for (std::size_t comma = 0; comma != std::string::npos; from = comma + 1) {
    comma = line.find(',', from);
    parts.push_back(line.substr(from, comma == std::string::npos ? comma : comma - from));
  }
  return parts;
}

// reads an empty text as NaN; false: the text is not a number that a double holds
bool ReadNumber(const std::string& text, double& value) {
  value = kNone;
  if (text.empty() || text == "nan" || text == "-nan") return true;
  const char* const end = text.data() + text.size();
  const auto [rest, fault] = std::from_chars(text.data(), end, value);
  return fault == std::errc() && rest == end && std::isfinite(value);
}

}  // namespace

const std::vector<double>* Series::Column(std::string_view name) const {
  const auto found = std::find(columns.begin(), columns.end(), name);
  return found == columns.end() ? nullptr
                                : &values[static_cast<std::size_t>(found - columns.begin())];
}

Result<Series> ReadSeries(const std::filesystem::path& csv) {
  Result<RegularFile> opened = RegularFile::Open(csv);
  if (!opened) return opened.error();
  LineReader lines(*std::move(opened), kLongestLine);
  std::string line;
  if (!lines.Next(line)) return Error{csv.string() + ": cannot be read"};
  Series series;
  series.columns = Split(line);
  // a picture would show the first of two columns of one name alone
  const std::set<std::string> names(series.columns.begin(), series.columns.end());
  if (names.size() < series.columns.size()) {
    return Error{csv.string() + ": line 1: two columns have one name"};
  }
  series.values.resize(series.columns.size());
  for (int number = 2; lines.Next(line); ++number) {
    if (static_cast<std::size_t>(number) * series.columns.size() > kMostNumbers) {
      return Error{csv.string() + ": more numbers than any case writes"};
    }
    const std::vector<std::string> parts = Split(line);
    const std::string place = csv.string() + ": line " + std::to_string(number);
    if (parts.size() != series.columns.size()) {
      return Error{place + ": expected " + std::to_string(series.columns.size()) + " values, got " +
                   std::to_string(parts.size())};
    }
    for (std::size_t i = 0; i < parts.size(); ++i) {
      double value = 0;
      if (!ReadNumber(parts[i], value)) {
        return Error{place + ": expected a number, got \"" + PlainLine(parts[i], 60) + '"'};
      }
      series.values[i].push_back(value);
    }
  }
  if (lines.too_long()) return Error{csv.string() + ": has a line that no case writes"};
  return series;
}

std::vector<PicturePoint> Thinned(const std::vector<double>& x, const std::vector<double>& y,
                                  std::size_t bins) {
  std::vector<PicturePoint> points;
  const std::size_t count = std::min(x.size(), y.size());
  const auto point = [&](std::size_t i) {
    return PicturePoint{x[i], y[i]};
  };
  if (count <= 2 * bins) {
    for (std::size_t i = 0; i < count; ++i) points.push_back(point(i));
    return points;
  }
  for (std::size_t bin = 0; bin < bins; ++bin) {
    const std::size_t from = bin * count / bins;
    const std::size_t to = (bin + 1) * count / bins;
    std::size_t least = to;
    std::size_t greatest = to;
    for (std::size_t i = from; i < to; ++i) {
      if (!std::isfinite(y[i])) continue;
      if (least == to || y[i] < y[least]) least = i;
      if (greatest == to || y[i] > y[greatest]) greatest = i;
    }
    if (least == to) {
      points.push_back({x[from], kNone});
      continue;
    }
    points.push_back(point(std::min(least, greatest)));
    if (least != greatest) points.push_back(point(std::max(least, greatest)));
  }
  return points;
}

}  // namespace tandem
