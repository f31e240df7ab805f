#include "collab/dds/cyclone/cyclone_threads.h"

#include <algorithm>
#include <atomic>
#include <ctime>
#include <string_view>

#include <dds/ddsrt/sync.h>
#include <dds/ddsrt/threads.h>
#include <dds/ddsrt/time.h>
#include <dlfcn.h>
#include <pthread.h>

namespace tandem {
namespace {

std::atomic<bool> has_small_stacks{false};

// Returns whether that thread reads received data. A type's description may be nested some thousand
// times, and Cyclone reads it recursively.
bool ReadsWhatOthersSend(std::string_view name) noexcept {
  return name.starts_with("dq.") || name.starts_with("recv");
}

}  // namespace

void SetCycloneStackSize() noexcept {
  has_small_stacks.store(true, std::memory_order_relaxed);
}

}  // namespace tandem

extern "C" {
// Cyclone finds these functions before its own.
dds_return_t ddsrt_thread_create(ddsrt_thread_t* thread, const char* name,
                                 const ddsrt_threadattr_t* attributes,
                                 ddsrt_thread_routine_t routine, void* argument) {
  static const auto cyclones =
      reinterpret_cast<decltype(&ddsrt_thread_create)>(dlsym(RTLD_NEXT, "ddsrt_thread_create"));
  ddsrt_threadattr_t own = *attributes;
  if (own.stackSize == 0 && !tandem::ReadsWhatOthersSend(name) &&
      tandem::has_small_stacks.load(std::memory_order_relaxed)) {
    own.stackSize = tandem::kCycloneStackBytes;
  }
  return cyclones(thread, name, &own, routine, argument);
}

// They return whether the condition was signalled.
bool ddsrt_cond_waitfor(ddsrt_cond_t* condition, ddsrt_mutex_t* mutex, dds_duration_t duration) {
  constexpr dds_duration_t kLongest = DDS_SECS(1'000'000'000);  // 30 years, far from overflow
  timespec until{};
  clock_gettime(CLOCK_MONOTONIC, &until);
  const dds_duration_t ns = until.tv_nsec + std::clamp<dds_duration_t>(duration, 0, kLongest);
  until.tv_sec += ns / DDS_NSECS_IN_SEC;
  until.tv_nsec = ns % DDS_NSECS_IN_SEC;
  return pthread_cond_clockwait(&condition->cond, &mutex->mutex, CLOCK_MONOTONIC, &until) == 0;
}

bool ddsrt_cond_waituntil(ddsrt_cond_t* condition, ddsrt_mutex_t* mutex, dds_time_t time) {
  if (time != DDS_NEVER) return ddsrt_cond_waitfor(condition, mutex, time - dds_time());
  return pthread_cond_wait(&condition->cond, &mutex->mutex) == 0;
}
}
