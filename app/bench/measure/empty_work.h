#pragma once

#include <algorithm>
#include <cstdint>

#include "app/bench/measure/bench_scene.h"

namespace tandem {

/// Arithmetic that touches no memory and takes as long as a frame. The machine causes its
/// variation.
class EmptyWork {
 public:
  /// Measures the processor's speed for some milliseconds, which must not be a loop's.
  EmptyWork() {
    constexpr std::uint64_t kProbe = 20000;
    double best = 1e18;
    for (int i = 0; i < 200; ++i)
      best = std::min(best, CpuNs([&] {
                        Run(kProbe);
                      }));
    steps_per_ns_ = kProbe / best;
  }
  /// Sets the work to what a quiet processor does in `ns`.
  void Size(double ns) { steps_ = static_cast<std::uint64_t>(ns * steps_per_ns_); }
  void operator()() { Run(steps_); }

 private:
  void Run(std::uint64_t steps) {
    std::uint64_t x = state_ | 1;
    for (std::uint64_t i = 0; i < steps; ++i) x = x * 6364136223846793005U + i;
    state_ = x;
  }
  double steps_per_ns_ = 1;
  std::uint64_t steps_ = 0;
  std::uint64_t state_ = 1;
};

}  // namespace tandem
