#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "collab/trace/network_trace.h"

namespace tandem {

/// Delays that two ends of a line noted for samples that both sent at a constant rate, each by its
/// own clock: arrival at the other end minus sending, ns. They include the difference of the
/// clocks.
struct PathRecord {
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min();

  double rate_hz = 1000;
  std::vector<std::int64_t> there_ns{};  // kNever: lost
  std::vector<std::int64_t> back_ns{};   // equally many
};

/// Estimate of the two clocks: the other end's minus ours.
struct ClockEstimate {
  std::int64_t offset_ns = 0;  // at the record's begin
  double drift_ppm = 0;        // drift of the offset; 0 where none shows
  /// Bound on the error of the offset: half the least round trip. The error is that large only if
  /// the least round trip is spent entirely in one direction.
  double bound_ms = 0;
};

/// Splits the least round trip evenly between both ways, and removes a drift if the least delays of
/// ten seconds or more show it. Sums over both ways do not depend on this. A record with nothing in
/// one of the ways has no estimate: all 0, and the bound below 0.
ClockEstimate EstimateClocks(const PathRecord& record);

/// Returns one-way delays by that estimate. A delay below 0, which a drift may leave, becomes 0.
NetworkTrace TraceOf(const PathRecord& record, const ClockEstimate& clocks);

}  // namespace tandem
