#include "app/common/stop_signal.h"

#include <algorithm>
#include <cerrno>
#include <condition_variable>
#include <csignal>
#include <cstdint>
#include <list>
#include <mutex>
#include <utility>

#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <sys/prctl.h>
#include <unistd.h>

#include "engine/base/units.h"
#include "engine/realtime/clock.h"
#include "engine/realtime/line_writer.h"

namespace tandem {
namespace {

constexpr std::size_t kEndingStackBytes = 1024 * 1024;

std::atomic<bool> stop_asked{false};
std::atomic<bool> ends_by_itself{false};
std::atomic<int> last_signal{0};
std::atomic<std::int64_t> newest_step_ns{0};
static_assert(std::atomic<int>::is_always_lock_free);  // a signal handler writes it
int signal_came = -1;                                  // eventfd

struct StopNews {
  std::mutex mutex;
  std::condition_variable changed;
};
// never destroyed: the thread of signals outlives main()
StopNews& News() {
  static auto& news = *new StopNews;
  return news;
}

struct ForcedEnds {
  std::mutex mutex;
  std::list<std::pair<const AtForcedEnd*, std::function<void()>>> acts;  // acts, the newest first
};
// never destroyed: the thread of the end outlives main()
ForcedEnds& Acts() {
  static auto& acts = *new ForcedEnds;
  return acts;
}

// Only write() may be called here; the thread does the rest.
void OnStopSignal(int signal) {
  const int before = errno;
  last_signal.store(signal);
  const std::uint64_t one = 1;
  const ssize_t ignored = write(signal_came, &one, sizeof one);
  static_cast<void>(ignored);
  errno = before;
}

/// Waits for a signal up to `ns`, or without end where `ns` is below 0. Returns whether it came.
bool SignalWithin(std::int64_t ns) {
  pollfd wait{signal_came, POLLIN, 0};
  const timespec time{ns / kSecondNs, ns % kSecondNs};
  if (ppoll(&wait, 1, ns < 0 ? nullptr : &time, nullptr) <= 0) return false;
  std::uint64_t count = 0;
  return read(signal_came, &count, sizeof count) == sizeof count;
}

/// Gives the program time to end by itself. Returns when this time is over.
void AwaitItsOwnEnd() {
  const std::int64_t requested_ns = MonotonicNowNs();
  newest_step_ns.store(requested_ns);
  {
    const std::scoped_lock lock(News().mutex);
    stop_asked.store(true);
  }
  News().changed.notify_all();
  for (;;) {
    const std::int64_t until_ns = std::min(newest_step_ns.load() + kEndingPatience.count() * kMs,
                                           requested_ns + kLongestEnding.count() * kMs);
    const std::int64_t left_ns = until_ns - MonotonicNowNs();
    if (left_ns <= 0) return;
    if (!SignalWithin(left_ns)) continue;
    if (MonotonicNowNs() - requested_ns >= kSecondSignal.count() * kMs) return;
  }
}

[[noreturn]] void EndByForce() {
  // never unlocked: what an act uses must not be destroyed while the act runs
  ForcedEnds& ends = Acts();
  ends.mutex.lock();
  for (const auto& [whose, act] : ends.acts) act();
  StandardError().Flush(kLastWordsPatience / 2);
  const int signal = last_signal.load();
  std::signal(signal, SIG_DFL);
  sigset_t one;
  sigemptyset(&one);
  sigaddset(&one, signal);
  pthread_sigmask(SIG_UNBLOCK, &one, nullptr);
  kill(getpid(), signal);
  _exit(128 + signal);
}

void* AwaitSignals(void* /*unused*/) {
  prctl(PR_SET_NAME, "signals");
  while (!SignalWithin(-1)) {
  }
  if (ends_by_itself.load()) AwaitItsOwnEnd();
  EndByForce();
}

void StartThread() {
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, kEndingStackBytes);
  pthread_attr_setdetachstate(&attributes, PTHREAD_CREATE_DETACHED);
  pthread_t thread{};
  pthread_create(&thread, &attributes, &AwaitSignals, nullptr);
  pthread_attr_destroy(&attributes);
}

}  // namespace

void HandleSignals() {
  static std::once_flag once;
  std::call_once(once, [] {
    signal_came = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    StartThread();
    // a handler rather than SIG_IGN, which child processes would inherit
    std::signal(SIGPIPE, [](int) {});
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
      if (std::signal(signal, OnStopSignal) == SIG_IGN) std::signal(signal, SIG_IGN);
    }
  });
}

const std::atomic<bool>& StopOnSignals() {
  HandleSignals();
  ends_by_itself.store(true);
  // overrides a shell, which ignores SIGINT for programs in the background
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, OnStopSignal);
  return stop_asked;
}

bool StopRequestedWithin(std::chrono::nanoseconds time) {
  std::unique_lock lock(News().mutex);
  return News().changed.wait_for(lock, time, [] {
    return stop_asked.load();
  });
}

void SayStillEnding() noexcept {
  newest_step_ns.store(MonotonicNowNs());
}

AtForcedEnd::AtForcedEnd(std::function<void()> act) {
  ForcedEnds& ends = Acts();
  const std::scoped_lock lock(ends.mutex);
  ends.acts.emplace_front(this, std::move(act));
}

AtForcedEnd::~AtForcedEnd() {
  ForcedEnds& ends = Acts();
  const std::scoped_lock lock(ends.mutex);
  ends.acts.remove_if([this](const auto& one) {
    return one.first == this;
  });
}

}  // namespace tandem
