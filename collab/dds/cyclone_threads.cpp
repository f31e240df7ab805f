#include "collab/dds/cyclone_threads.h"

#include <atomic>
#include <string_view>

#include <dds/ddsrt/threads.h>
#include <dlfcn.h>

namespace tandem {
namespace {

std::atomic<bool> has_small_stacks{false};

// These read what others send. A description of a type may be nested some thousand times, and
// Cyclone reads it by a function that calls itself.
bool ReadsWhatOthersSend(std::string_view name) noexcept {
  return name.starts_with("dq.") || name.starts_with("recv");
}

}  // namespace

void GiveCycloneSmallStacks() noexcept {
  has_small_stacks.store(true, std::memory_order_relaxed);
}

}  // namespace tandem

extern "C" {
// Cyclone's own, which finds this one before its own.
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
}
