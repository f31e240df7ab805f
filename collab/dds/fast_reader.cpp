#include "collab/dds/fast_reader.h"

#include <array>
#include <ctime>
#include <string_view>

#include <pthread.h>

namespace tandem {

std::int64_t MonotonicNow_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

bool OnReceiveThread() noexcept {
  // the only one of Cyclone's threads of that name, as MultipleReceiveThreads is off
  static thread_local const bool is = [] {
    std::array<char, 16> name{};
    return pthread_getname_np(pthread_self(), name.data(), name.size()) == 0 &&
           std::string_view(name.data()) == "recv";
  }();
  return is;
}

}  // namespace tandem
