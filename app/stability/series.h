#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "app/picture/picture.h"
#include "engine/base/result.h"

namespace tandem {

/// A table of numbers in time, as `tandem stability run --series` writes it;
/// what is not there is no number.
struct Series {
  std::vector<std::string> columns;
  std::vector<std::vector<double>> values;  // of each column

  /// Of the column of that name; null when there is none.
  const std::vector<double>* Column(std::string_view name) const;
};

/// Errors name the file and the line.
Result<Series> ReadSeries(const std::filesystem::path& csv);

/// At most two points for each of so many bins of x, the least and the greatest
/// y in their order, so that no peak is lost.
std::vector<PicturePoint> Thinned(const std::vector<double>& x, const std::vector<double>& y,
                                  std::size_t bins);

/// Distance, speeds, forces, stiffness and age, one above the other over the
/// time: of columns t_s, apart_mm, and of each user N vN_mm_s, forceN_N,
/// linkN_N, stiffnessN_N_m, loopN_ms.
Picture PictureOf(const Series& series, const std::string& name, const std::string& title,
                  const std::string& note);

}  // namespace tandem
