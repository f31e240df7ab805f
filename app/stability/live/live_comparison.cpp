#include "app/stability/live/live_comparison.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tandem {

std::span<const ComparedFigure> ComparedFigures() {
  static constexpr ComparedFigure kAll[] = {
      {"divergence at the most", 1e3, "mm", &Metrics::peak_apart, 1e-4, true},
      {"hand's force at the most", 1, "N", &Metrics::peak_force, 1e-2, true},
      {"divergence at the end", 1e3, "mm", &Metrics::last_apart, 1e-4, false},
      {"link's force at the most", 1, "N", &Metrics::link_force, 1e-2, false},
      {"stiffness at the end", 1, "N/m", &Metrics::stiffness, 1e-2, false},
      {"loop age", 1e3, "ms", &Metrics::loop_age_s, 1e-3, false},
      {"tail RMS", 1e3, "mm/s", &Metrics::tail_rms, 1e-4, false},
      {"growth", 1, "1/s", &Metrics::growth, 1e-2, false},
      {"energy generated", 1e3, "mJ", &Metrics::generated_J, 1e-6, false}};
  return kAll;
}

double DeviationOf(const ComparedFigure& figure, const Metrics& live, const Metrics& virtual_time) {
  const double reference = virtual_time.*figure.value;
  const double off = (live.*figure.value - reference) / std::max(std::abs(reference), figure.least);
  return std::isfinite(off) ? off : std::numeric_limits<double>::infinity();
}

}  // namespace tandem
