#include "collab/dds/fast_reader.h"

#include <string_view>

#include <pthread.h>
#include <time.h>

namespace tandem {

std::int64_t MonotonicNow_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

bool OnReceiveThread() noexcept {
  // the only one of Cyclone's threads of that name, as MultipleReceiveThreads is off
  static thread_local const bool is = [] {
    char name[16] = {};
    return pthread_getname_np(pthread_self(), name, sizeof name) == 0 &&
           std::string_view(name) == "recv";
  }();
  return is;
}

}  // namespace tandem
