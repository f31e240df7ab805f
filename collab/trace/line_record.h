#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "collab/trace/network_trace.h"

namespace tandem {

/// What two ends of a line noted down of samples that both sent at a constant rate, each by its own
/// clock: the arrival at the other end minus the sending, ns, which holds the difference of the
/// clocks.
struct LineRecord {
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min();

  double rate_hz = 1000;
  std::vector<std::int64_t> there_ns{};  // kNever: lost
  std::vector<std::int64_t> back_ns{};   // as many
};

/// What is known of the two clocks: the other end's minus ours.
struct ClockEstimate {
  std::int64_t offset_ns = 0;  // at the record's begin
  double drift_ppm = 0;        // of the offset; 0 where none shows
  /// The offset is right within this: half the least round trip. It is that far off only if all of
  /// the least round trip is spent in one direction.
  double bound_ms = 0;
};

/// Splits the least round trip evenly between both ways, and takes a drift away that the least
/// delays of ten seconds or more show. What is summed over both ways owes nothing to this. A record
/// with nothing in one of the ways has no estimate: all 0, the bound below 0.
ClockEstimate EstimateClocks(const LineRecord& record);

/// One-way delays by that estimate. A delay below 0, which a drift may leave, is 0.
NetworkTrace TraceOf(const LineRecord& record, const ClockEstimate& clocks);

}  // namespace tandem
