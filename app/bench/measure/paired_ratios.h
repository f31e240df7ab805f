#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace tandem {

/// Returns the median; for an even number of values, the mean of the middle two.
inline double MedianOf(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
}

/// The ratios of figures to a base that is measured again in every round.
struct PairedRatios {
  double median = 0;
  double least = 0;
  double most = 0;
};

/// Returns the ratios of figures to their base. Each vector holds one figure for each round. The
/// base of a round is the mean of the runs before and after, so a drift of the machine meets both
/// sides of a ratio. Noise widens the spread of the ratios and does not lower their median.
inline PairedRatios RatiosToBase(const std::vector<double>& figures,
                                 const std::vector<double>& before,
                                 const std::vector<double>& after) {
  std::vector<double> ratios;
  for (std::size_t round = 0; round < figures.size(); ++round) {
    ratios.push_back(figures[round] / (0.5 * (before[round] + after[round])));
  }
  return {MedianOf(ratios), std::ranges::min(ratios), std::ranges::max(ratios)};
}

/// Returns the ratio of the larger to the smaller of two equal runs, as the median of the rounds.
/// Noise alone makes it.
inline double RatioOfEquals(const std::vector<double>& before, const std::vector<double>& after) {
  std::vector<double> ratios;
  for (std::size_t round = 0; round < before.size(); ++round) {
    ratios.push_back(std::max(before[round], after[round]) / std::min(before[round], after[round]));
  }
  return MedianOf(ratios);
}

}  // namespace tandem
