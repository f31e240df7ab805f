#include "collab/dds/transport/receive_thread.h"

#include <array>
#include <string_view>
#include <thread>

#include <pthread.h>
#include <sched.h>
#include <unistd.h>

namespace tandem {
namespace {

using ThreadName = std::array<char, 16>;

constexpr const char* kOfAll = "recv";
constexpr const char* kOfData = "recvUC";

// Priorities of SCHED_FIFO; the haptic thread's is 30 (engine/realtime/periodic_thread.h).
constexpr int kAboveHaptic = 40;
constexpr int kBelowHaptic = 25;
constexpr int kReceiveThreads = 2;

bool BecomeRealTime() noexcept {
  sched_param parameters{};
  parameters.sched_priority = ReceivePriority();
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) == 0;
}

}  // namespace

int ReceivePriority(int cores) noexcept {
  return cores > kReceiveThreads ? kAboveHaptic : kBelowHaptic;
}

int ReceivePriority() noexcept {
  cpu_set_t allowed;
  if (sched_getaffinity(getpid(), sizeof allowed, &allowed) != 0) return kBelowHaptic;
  return ReceivePriority(CPU_COUNT(&allowed));
}

const char* ReceiveThreadOf(const DdsOptions& options) noexcept {
  return options.interface == "lo" && options.external_address.empty() ? kOfData : kOfAll;
}

bool HasTheSocketToItself(const DdsOptions& options) noexcept {
  return ReceiveThreadOf(options) == kOfData;
}

bool OnReceiveThread(const char* name) noexcept {
  static thread_local const ThreadName own = [] {
    ThreadName read{};
    pthread_getname_np(pthread_self(), read.data(), read.size());
    return read;
  }();
  if (std::string_view(own.data()) != name) return false;
  static thread_local const bool real_time = BecomeRealTime();
  static_cast<void>(real_time);
  return true;
}

bool RealTimeIsPermitted() {
  bool permitted = false;
  std::thread([&] {
    permitted = BecomeRealTime();
  }).join();
  return permitted;
}

}  // namespace tandem
