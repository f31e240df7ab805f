#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace tandem {

/// The median; of an even number of values the mean of the middle two.
inline double MedianOf(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
}

/// How figures compare with a base that is measured again in every round.
struct PairedRatios {
  double median = 0;
  double least = 0;
  double most = 0;
};

/// Each vector holds one figure for each round. The base of a round is the mean of the runs before
/// and after, so a drift of the machine meets both sides of a ratio. Noise widens the spread of the
/// ratios and does not lower their median.
inline PairedRatios RatiosToBase(const std::vector<double>& figures,
                                 const std::vector<double>& before,
                                 const std::vector<double>& after) {
  std::vector<double> ratios;
  for (std::size_t round = 0; round < figures.size(); ++round) {
    ratios.push_back(figures[round] / (0.5 * (before[round] + after[round])));
  }
  return {MedianOf(ratios), std::ranges::min(ratios), std::ranges::max(ratios)};
}

/// The larger of two runs of one kind by the smaller, median of the rounds: what noise alone makes.
inline double RatioOfEquals(const std::vector<double>& before, const std::vector<double>& after) {
  std::vector<double> ratios;
  for (std::size_t round = 0; round < before.size(); ++round) {
    ratios.push_back(std::max(before[round], after[round]) / std::min(before[round], after[round]));
  }
  return MedianOf(ratios);
}

}  // namespace tandem
