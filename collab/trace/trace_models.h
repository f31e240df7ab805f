#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "collab/trace/network_trace.h"
#include "engine/base/result.h"

namespace tandem {

/// What one way of a modelled line does to a sample. All samples keep their order: each part is a
/// queue. docs/network-plans.md says which figures are published and which are chosen.
struct WayModel {
  double base_ms = 0;       // least delay
  double grid_ms = 0;       // sending begins at multiples of this: a sample waits for the next one
  double queue_ms = 0;      // mean wait behind other traffic, which varies (log-normal)
  double queue_spread = 1;  // standard deviation of the logarithm
  double queue_s = 0.2;     // time over which the wait changes
  // sent again by the link layer, so often at the most
  double retry = 0;  // chance of each try
  double retry_ms = 0;
  int retries = 3;
  // nothing passes, then all that waited does: scans, contention, handovers
  double stalls_hz = 0;
  double stall_ms = 0;       // mean, exponential; or always as long
  bool stall_fixed = false;  //
  // losses (Gilbert and Elliott, as of LinkConditions)
  double loss = 0;
  double burst_enter = 0;
  double burst_leave = 1;
  double burst_loss = 1;
  // a satellite hands over to the next at a fixed period
  double period_s = 0;
  double period_spread_ms = 0;  // each period has a delay of its own, up to this more
  double begin_ms = 0;          // from the period's beginning, and before its end,
  double end_ms = 0;
  double boundary_ms = 0;    // up to so much more,
  double boundary_loss = 0;  // and this share is lost
  // a queue that one bulk transfer fills (CUBIC): 0: none
  double buffer_ms = 0;      // of a full buffer
  double transfer_s = 0;     // a transfer lasts,
  double pause_s = 0;        // and a pause
  double round_trip_ms = 0;  // of the transfer, with an empty buffer
  double packets_per_s = 0;  // of the bottleneck
};

struct TraceModel {
  std::string name;
  std::string title;
  WayModel there;
  WayModel back;
};

std::span<const TraceModel> TraceModels();

struct TraceLength {
  double seconds = 60;
  double rate_hz = 1000;
  std::uint64_t seed = 1;
};

/// Makes a trace of that model; the same for the same length, rate and seed. Errors: there is no
/// such model, or the trace would be too long.
Result<NetworkTrace> MakeTrace(const std::string& name, const TraceLength& length);

}  // namespace tandem
