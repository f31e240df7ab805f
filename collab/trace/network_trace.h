#pragma once

#include <string>
#include <vector>

namespace tandem {

/// Delays and losses of a line, for samples that both of its ends sent at a constant rate. Element
/// i of each way is the sample sent i periods after the first.
struct NetworkTrace {
  static constexpr float kLost = -1;

  double rate_hz = 1000;
  std::vector<float> there_ms{};  // one-way delay of each sample, kLost where it never arrived
  std::vector<float> back_ms{};   // equally many
  std::string source{};           // origin, in one line
  /// Bound on the error of the clocks, ms: all delays there may be too large by it and those back
  /// too small, or the reverse. Below 0: unknown.
  double clock_bound_ms = -1;
};

}  // namespace tandem
