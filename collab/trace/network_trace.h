#pragma once

#include <string>
#include <vector>

namespace tandem {

/// What a line did to samples that both of its ends sent at a constant rate. Element i of each way
/// is the sample that was sent i periods after the first.
struct NetworkTrace {
  static constexpr float kLost = -1;

  double rate_hz = 1000;
  std::vector<float> there_ms{};  // one-way delay of each sample, kLost where it never arrived
  std::vector<float> back_ms{};   // as many
  std::string source{};           // how it was made, one line
  /// By how much all delays there may be too large, and those back too small, or the reverse: the
  /// clocks of both ends are not known better. Below 0: nothing is known of that.
  double clock_bound_ms = -1;
};

}  // namespace tandem
