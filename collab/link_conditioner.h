#pragma once

#include <cstdint>
#include <optional>
#include <random>

namespace tandem {

/// What a link does to what arrives over it.
struct LinkConditions {
  double delay_ms = 0;   // added to every sample
  double jitter_ms = 0;  // up to this much more, evenly spread
  double loss = 0;       // share that never arrives, 0 to 1
  std::uint64_t seed = 1;
};

/// Injects delay, jitter and loss where samples are received: the same object in real and in
/// virtual time, so that a run can be repeated. Order is kept: a sample is never due before one
/// that arrived earlier. Used by the receive thread alone.
class LinkConditioner {
 public:
  explicit LinkConditioner(const LinkConditions& conditions);

  /// When a sample that arrives now is to be delivered (the receiver's clock, ns), or nothing:
  /// lost.
  std::optional<std::int64_t> Due(std::int64_t arrival_ns) noexcept;

 private:
  double Random() noexcept;  // [0, 1)

  LinkConditions conditions_;
  std::mt19937_64 random_;
  std::int64_t latest_due_ns_ = 0;
};

}  // namespace tandem
