#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <random>

#include "collab/receive/link_trace.h"

namespace tandem {

/// Conditions of a link in one direction; two of them make a link asymmetric.
struct LinkConditions {
  double delay_ms = 0;   // delay added to every sample
  double jitter_ms = 0;  // further delay, evenly distributed from 0 to this
  double swing_ms = 0;   // delay + swing sin(2 pi t / period), never below 0
  double swing_period_s = 10;
  double loss = 0;  // share of samples lost, 0 to 1
  // bursts (Gilbert and Elliott): chance that a burst begins, or ends, before a sample
  double burst_enter = 0;
  double burst_leave = 1;
  double burst_loss = 1;  // share lost within a burst
  double reorder = 0;     // share of samples held back, so that later ones overtake them
  double reorder_ms = 0;  // longest time held back
  double duplicate = 0;   // share of samples that arrive twice
  bool cut = false;       // nothing arrives
  std::uint64_t seed = 1;
  /// Delays and losses of a real line, applied first: its delay is added, its losses and its order
  /// stay. Null: none. Never freed while a thread may use it (collab/trace/trace_store.h).
  const LinkTrace* trace = nullptr;
  double trace_start_s = 0;  // place in the trace where playing begins
};

/// Adds delay, jitter, loss, reordering and duplicates where samples are received. Real and virtual
/// time use the same class, so that a run can be repeated. Samples stay in order, except those that
/// are reordered, or were in the trace. Used by one thread, the receiving one.
class LinkConditioner {
 public:
  /// `stream` identifies a link of the receiver: each link has its own random stream.
  explicit LinkConditioner(const LinkConditions& conditions, std::uint64_t stream = 0);

  /// Changes the conditions: an outage, a better route. The random stream goes on, and begins anew
  /// with another seed. The trace goes on too; another trace begins with the next sample.
  void Switch(const LinkConditions& conditions) noexcept;
  const LinkConditions& conditions() const noexcept { return conditions_; }

  /// Writes when a sample that arrives now is to be delivered (the receiver's clock, ns), once for
  /// each copy. Returns the number of copies: 0 (lost), 1 or 2.
  std::size_t Due(std::int64_t arrival_ns, std::array<std::int64_t, 2>& due_ns) noexcept;

 private:
  double Random() noexcept;  // [0, 1)
  bool Lost() noexcept;
  /// The trace's sample for a sample that arrives now; null: there is no trace.
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
