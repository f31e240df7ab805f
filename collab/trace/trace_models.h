#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "collab/trace/network_trace.h"
#include "engine/base/result.h"

namespace tandem {

/// Model of one way of a line. Samples keep their order: each part is a queue.
/// docs/network-plans.md says which figures are published and which are chosen.
struct DirectionModel {
  double base_ms = 0;       // least delay
  double grid_ms = 0;       // sending begins at multiples of this: a sample waits for the next
  double queue_ms = 0;      // mean wait behind other traffic, which varies (log-normal)
  double queue_spread = 1;  // standard deviation of the logarithm
  double queue_s = 0.2;     // time over which the wait changes
  // retransmissions by the link layer, a limited number
  double retry = 0;  // chance of each try
  double retry_ms = 0;
  int retries = 3;
  // stalls: nothing passes, then all waiting samples do; scans, contention, handovers
  double stalls_hz = 0;
  double stall_ms = 0;       // mean of an exponential distribution, or the constant length
  bool stall_fixed = false;  // stalls have a constant length
  // losses (Gilbert and Elliott, as in LinkConditions)
  double loss = 0;
  double burst_enter = 0;
  double burst_leave = 1;
  double burst_loss = 1;
  // a satellite hands over to the next at a fixed period
  double period_s = 0;
  double period_spread_ms = 0;  // each period has its own further delay, up to this
  double begin_ms = 0;          // time after the beginning of a period, and
  double end_ms = 0;            // before its end, which a handover affects
  double boundary_ms = 0;       // greatest further delay in that time
  double boundary_loss = 0;     // share lost in that time
  // a queue that one bulk transfer (CUBIC) fills; 0: none
  double buffer_ms = 0;      // wait in a full buffer
  double transfer_s = 0;     // length of a transfer,
  double pause_s = 0;        // and of the pause after it
  double round_trip_ms = 0;  // round trip of the transfer, with an empty buffer
  double packets_per_s = 0;  // rate of the bottleneck
};

struct TraceModel {
  std::string name;
  std::string title;
  DirectionModel there;
  DirectionModel back;
};

std::span<const TraceModel> TraceModels();

struct TraceLength {
  double seconds = 60;
  double rate_hz = 1000;
  std::uint64_t seed = 1;
};

/// Makes a trace of that model; the same for the same length, rate and seed. Errors: no model has
/// that name, or the trace would be too long.
Result<NetworkTrace> MakeTrace(const std::string& name, const TraceLength& length);

}  // namespace tandem
