#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <random>

#include "collab/link_trace.h"

namespace tandem {

/// What a link does to what arrives over it, in one direction: two of them make it asymmetric.
struct LinkConditions {
  double delay_ms = 0;         // added to every sample
  double jitter_ms = 0;        // up to this much more, evenly spread
  double swing_ms = 0;         // delay + swing sin(2 pi t / period), never below 0
  double swing_period_s = 10;  //
  double loss = 0;             // share that never arrives, 0 to 1
  // bursts (Gilbert and Elliott): before each sample a burst begins or ends with these chances
  double burst_enter = 0;
  double burst_leave = 1;
  double burst_loss = 1;  // share lost within a burst
  double reorder = 0;     // share held back, so that later ones overtake it,
  double reorder_ms = 0;  // by up to so much
  double duplicate = 0;   // share that arrives twice
  bool cut = false;       // nothing arrives
  std::uint64_t seed = 1;
  /// What a real line did, before all else: its delay is added, its losses and its order are kept.
  /// Null: none. Never freed while anybody may use it (collab/trace/trace_store.h).
  const LinkTrace* trace = nullptr;
  double trace_start_s = 0;  // place in the trace where it begins
};

/// Injects delay, jitter, loss, disorder and copies where samples are received: the same object in
/// real and in virtual time, so that a run can be repeated. A sample is never due before one that
/// arrived earlier, but for those that are reordered. Used by one thread, the receiving one.
class LinkConditioner {
 public:
  /// `stream` tells apart the links of one receiver: each has a random stream of its own.
  explicit LinkConditioner(const LinkConditions& conditions, std::uint64_t stream = 0);

  /// Other conditions from now on: an outage, a better route. The random stream goes on; with
  /// another seed it begins anew. So does a trace: it goes on, and another one begins with the next
  /// sample.
  void Switch(const LinkConditions& conditions) noexcept;
  const LinkConditions& conditions() const noexcept { return conditions_; }

  /// When a sample that arrives now is to be delivered (the receiver's clock, ns): writes as many
  /// times as there are copies, 0 (lost), 1 or 2, and gives their number.
  std::size_t Due(std::int64_t arrival_ns, std::array<std::int64_t, 2>& due_ns) noexcept;

 private:
  double Random() noexcept;  // [0, 1)
  bool Lost() noexcept;
  /// What the trace has for a sample that arrives now; null: there is no trace.
  const TracedSample* Traced(std::int64_t arrival_ns) noexcept;

  LinkConditions conditions_;
  std::uint64_t stream_;
  std::mt19937_64 random_;
  bool in_burst_ = false;
  std::int64_t latest_due_ns_ = INT64_MIN;
  bool trace_begun_ = false;
  std::int64_t trace_begin_ns_ = 0;
};

}  // namespace tandem
