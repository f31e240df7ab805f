// A wall clock that can be set for one program: a library that is loaded before all others
// (LD_PRELOAD). It adds to CLOCK_REALTIME the nanoseconds that stand in a file, which the variable
// STEPPED_CLOCK names and which another program writes at any time. Without the variable it adds
// nothing. The machine's clock is left alone, and so are all other clocks, but with the variable
// STEPPED_CLOCK_SLEEPS the clock that goes on while a machine sleeps is ahead as much.
//
// A wait of a condition variable until a time of that clock ends by the stepped clock, as the
// kernel does it when a clock is set: earlier after a step forward, later after a step back. The
// library takes every such wait for one by CLOCK_REALTIME, the default. It waits in slices, and a
// signal that comes between two slices ends the wait.
#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdlib>

#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

namespace {

constexpr std::int64_t kSecond = 1'000'000'000;  // ns
constexpr std::int64_t kSlice = 20'000'000;      // ns

template <typename Function>
Function* Next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

int KernelClock(clockid_t clock, timespec* time) noexcept {
  static const auto next = Next<int(clockid_t, timespec*)>("clock_gettime");
  return next(clock, time);
}

std::int64_t Nanoseconds(const timespec& time) noexcept {
  return kSecond * time.tv_sec + time.tv_nsec;
}

timespec TimeOf(std::int64_t ns) noexcept {
  timespec time{};
  time.tv_sec = ns / kSecond;
  time.tv_nsec = ns % kSecond;
  return time;
}

std::int64_t NowBy(clockid_t clock) noexcept {
  timespec now{};
  KernelClock(clock, &now);
  return Nanoseconds(now);
}

const std::atomic<std::int64_t>* MappedStep() noexcept {
  const char* const file = std::getenv("STEPPED_CLOCK");
  if (file == nullptr) return nullptr;
  const int descriptor = open(file, O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return nullptr;
  void* const mapped = mmap(nullptr, sizeof(std::int64_t), PROT_READ, MAP_SHARED, descriptor, 0);
  close(descriptor);
  return mapped == MAP_FAILED ? nullptr : static_cast<const std::atomic<std::int64_t>*>(mapped);
}

/// Returns by how much the clock is ahead of the kernel's.
std::int64_t Step() noexcept {
  static const std::atomic<std::int64_t>* const step = MappedStep();
  return step == nullptr ? 0 : step->load(std::memory_order_relaxed);
}

bool IsWallClock(clockid_t clock) noexcept {
  static const bool sleeps = std::getenv("STEPPED_CLOCK_SLEEPS") != nullptr;
  return clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE ||
         (sleeps && clock == CLOCK_BOOTTIME);
}

/// Counts the signals of condition variables; variables far apart may share a count.
std::atomic<std::uint32_t>& SignalsOf(const pthread_cond_t* condition) noexcept {
  static std::array<std::atomic<std::uint32_t>, 4096> counts;
  return counts[(reinterpret_cast<std::uintptr_t>(condition) >> 4U) % counts.size()];
}

}  // namespace

extern "C" {

int clock_gettime(clockid_t clock, timespec* time) noexcept {
  const int failed = KernelClock(clock, time);
  if (failed == 0 && IsWallClock(clock)) *time = TimeOf(Nanoseconds(*time) + Step());
  return failed;
}

int gettimeofday(timeval* time, void*) noexcept {
  const std::int64_t now = NowBy(CLOCK_REALTIME) + Step();
  time->tv_sec = now / kSecond;
  time->tv_usec = now % kSecond / 1000;
  return 0;
}

time_t time(time_t* time) noexcept {
  const time_t now = (NowBy(CLOCK_REALTIME) + Step()) / kSecond;
  if (time != nullptr) *time = now;
  return now;
}

int pthread_cond_signal(pthread_cond_t* condition) noexcept {
  static const auto next = Next<int(pthread_cond_t*)>("pthread_cond_signal");
  SignalsOf(condition).fetch_add(1);
  return next(condition);
}

int pthread_cond_broadcast(pthread_cond_t* condition) noexcept {
  static const auto next = Next<int(pthread_cond_t*)>("pthread_cond_broadcast");
  SignalsOf(condition).fetch_add(1);
  return next(condition);
}

int pthread_cond_timedwait(pthread_cond_t* condition, pthread_mutex_t* mutex,
                           const timespec* until) {
  const std::uint32_t signals = SignalsOf(condition).load();
  for (;;) {
    const std::int64_t left = Nanoseconds(*until) - NowBy(CLOCK_REALTIME) - Step();
    const timespec end = TimeOf(NowBy(CLOCK_MONOTONIC) + std::clamp<std::int64_t>(left, 0, kSlice));
    const int result = pthread_cond_clockwait(condition, mutex, CLOCK_MONOTONIC, &end);
    if (result != ETIMEDOUT || left <= 0) return result;
    if (SignalsOf(condition).load() != signals) return 0;
  }
}
}
