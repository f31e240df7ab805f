#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <thread>

#include "tests/network/running_program.h"

namespace tandem::testing {

inline constexpr std::int64_t kMostGrowth = 16 * 1024 * 1024;  // bytes
inline constexpr std::int64_t kMostKept = 2 * 1024 * 1024;     // bytes, a minute after a flood
inline constexpr double kGivenBackSeconds = 60;

/// Waits until starting and meeting have taken all their memory: for a second it has not grown any
/// more. Returns the memory, bytes.
inline std::int64_t MemoryAtRest(const Program& program) {
  constexpr double kStep = 0.1;
  constexpr int kQuiet = 10;             // steps
  constexpr double kSettleSeconds = 30;  // at the most
  std::int64_t most = program.Memory();
  int quiet = 0;
  for (double waited = 0; quiet < kQuiet && waited < kSettleSeconds; waited += kStep) {
    std::this_thread::sleep_for(std::chrono::duration<double>(kStep));
    const std::int64_t now = program.Memory();
    quiet = now > most + 65'536 ? 0 : quiet + 1;
    most = std::max(most, now);
  }
  return most;
}

}  // namespace tandem::testing
