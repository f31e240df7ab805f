#pragma once

#include <cstdint>

namespace tandem {

/// Starts, once in a process, a thread that watches this machine's networks. The kernel tells it of
/// changes. It joins networks that come. Where an address has gone by which others reach a domain,
/// or this program did not run for a while, it cuts the domain for kCutNs, in which both sides
/// forget one another. They then meet anew by the networks that are there, as after a cut cable.
/// Without the cut one side might forget what the other one goes on believing.
void WatchNetworks();

/// A cut is longer than the lease of a program (domain.cpp).
inline constexpr std::int64_t kCutNs = 2'600'000'000;

/// Tells from two clocks that this program did not run: it was stopped, or its machine slept.
class PauseDetector {
 public:
  /// Others have forgotten a program that was silent for its lease.
  static constexpr std::int64_t kLongestTurnNs = 2'000'000'000;

  PauseDetector(std::int64_t monotonic_ns, std::int64_t with_sleep_ns)
      : monotonic_ns_(monotonic_ns), with_sleep_ns_(with_sleep_ns) {}
  /// Call it every turn. `monotonic_ns` stands while the machine sleeps, `with_sleep_ns` does not.
  bool Paused(std::int64_t monotonic_ns, std::int64_t with_sleep_ns);

 private:
  std::int64_t monotonic_ns_;
  std::int64_t with_sleep_ns_;
};

}  // namespace tandem
