#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "app/picture/picture.h"
#include "engine/base/result.h"

namespace tandem {

/// A table of numbers over time, as `tandem stability run --series` writes it. A missing value is
/// NaN.
struct Series {
  std::vector<std::string> columns;
  std::vector<std::vector<double>> values;  // values of each column

  /// Returns the column of that name; null: there is none.
  const std::vector<double>* Column(std::string_view name) const;
};

/// Errors name the file and the line.
Result<Series> ReadSeries(const std::filesystem::path& csv);

/// Reduces a curve to at most two points in each of `bins` bins of x, the least and the greatest y
/// in their order. So no peak is lost.
std::vector<PicturePoint> Thinned(const std::vector<double>& x, const std::vector<double>& y,
                                  std::size_t bins);

/// Draws distance, speeds, forces, stiffness and age over time, in panels one above the other. Uses
/// the columns t_s, apart_mm, and for each user N vN_mm_s, forceN_N, linkN_N, stiffnessN_N_m,
/// loopN_ms.
Picture PictureOf(const Series& series, const std::string& name, const std::string& title,
                  const std::string& note);

}  // namespace tandem
