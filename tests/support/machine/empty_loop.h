#pragma once

#include <cstdint>

#include "engine/realtime/periodic_thread.h"

namespace tandem::testing {

/// Measures the frames that this machine takes from a program of 1 kHz, beside a test that has a
/// bound on missed frames. It is a loop of that rate that does nothing, comes before the program's
/// threads, and so misses only what it gets no processor for. On a quiet machine it misses none.
class EmptyLoop {
 public:
  /// `core`: the only one it may have, as the program has; below 0: any.
  explicit EmptyLoop(int core = -1)
      : thread_({.priority = 40, .core = core, .name = "empty-loop"},
                [](std::int64_t, std::int64_t) noexcept {
                  return true;
                }) {}

  /// Ends the loop. Returns the share of its deadlines that passed without a frame, 0 to 1.
  double End() {
    thread_.Stop();
    thread_.Join();
    const auto missed = static_cast<double>(thread_.stats().missed());
    return missed / (missed + static_cast<double>(thread_.stats().frames()));
  }

 private:
  PeriodicThread thread_;
};

}  // namespace tandem::testing
