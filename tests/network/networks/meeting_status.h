#pragma once

#include <atomic>
#include <cstdint>

namespace tandem::testing {

/// Tells what a meeting_peer sees of the other one, in a file that both programs map. Times are of
/// CLOCK_MONOTONIC, which all machines of a test share.
struct MeetingStatus {
  std::atomic<std::int64_t> began_ns;    // when it had joined
  std::atomic<std::int64_t> arrived_ns;  // arrival of the newest state
  std::atomic<std::int64_t> here;        // 1: the other one is here
  std::atomic<std::int64_t> lost;        // how often it was lost
};

}  // namespace tandem::testing
