#include "engine/realtime/worker_pool.h"

#include <algorithm>
#include <ctime>

#include <pthread.h>
#include <sched.h>
#include <sys/prctl.h>

#include "engine/base/check.h"
#include "engine/realtime/clock.h"

namespace tandem {
namespace {

constexpr int kLooksAMoment = 64;         // polls between looks at the clock
constexpr int kLooksBeforeYield = 20000;  // about a millisecond

void Relax() noexcept {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

/// Returns the number of processors that this process may use.
int Processors() noexcept {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof(set), &set) != 0) return 1;
  return CPU_COUNT(&set);
}

RealtimeStatus Granted(int priority) noexcept {
  if (priority > 0) return EnterRealtime(priority);
  RealtimeStatus ordinary;
  ordinary.timer_slack = prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL) == 0;
  return ordinary;
}

}  // namespace

WorkerPool::WorkerPool(const Options& options) {
  TANDEM_CHECK(options.threads >= 1 && options.threads <= kMostThreads);
  // more than one thread on a processor would wait for one another
  const int count = std::clamp(options.threads, 1, std::max(1, Processors())) - 1;
  std::vector<RealtimeStatus> granted(static_cast<std::size_t>(count));
  std::latch running(count);
  for (int k = 0; k < count; ++k) {
    workers_.emplace_back([this, &running, &granted, k, priority = options.priority] {
      granted[static_cast<std::size_t>(k)] = Granted(priority);
      running.count_down();
      RunWorker(k + 1);
    });
    clockid_t clock{};
    TANDEM_CHECK(pthread_getcpuclockid(workers_.back().native_handle(), &clock) == 0);
    clocks_.push_back(clock);
  }
  running.wait();
  const auto least =
      std::min_element(granted.begin(), granted.end(), [](const auto& a, const auto& b) {
        return !a.fifo && b.fifo;
      });
  realtime_ = least != granted.end() ? *least
                                     : RealtimeStatus{.fifo = true,
                                                      .priority = options.priority,
                                                      .timer_slack = true,
                                                      .memory_locked = true,
                                                      .stack_prefaulted = true,
                                                      .warning = {}};
}

WorkerPool::~WorkerPool() {
  end_.store(true, std::memory_order_relaxed);
  call_.fetch_add(1, std::memory_order_release);
  call_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

void WorkerPool::WakeWorkers() noexcept {
  const std::uint32_t call = call_.load(std::memory_order_relaxed);
  if (workers_.empty() || call % 2 == 1) return;
  call_.store(call + 1, std::memory_order_release);
  call_.notify_all();
}

void WorkerPool::ReleaseWorkers() noexcept {
  const std::uint32_t call = call_.load(std::memory_order_relaxed);
  if (call % 2 == 1) call_.store(call + 1, std::memory_order_release);
}

void WorkerPool::Run(const Job& job) noexcept {
  if (job.count == 0) return;
  job_ = job;
  const std::uint32_t pieces = job_.Pieces();
  done_.store(0, std::memory_order_relaxed);
  left_.store(pieces, std::memory_order_release);
  while (DoPiece(0)) {
  }
  for (int exact_queries = 1; done_.load(std::memory_order_acquire) != pieces; ++exact_queries) {
    Relax();
    // a worker may be waiting for this very processor
    if (exact_queries % kLooksBeforeYield == 0) sched_yield();
  }
}

bool WorkerPool::DoPiece(int thread) noexcept {
  std::uint32_t left = left_.load(std::memory_order_relaxed);
  do {
    if (left == 0) return false;
  } while (!left_.compare_exchange_weak(left, left - 1, std::memory_order_acquire,
                                        std::memory_order_relaxed));
  const std::size_t begin = (job_.Pieces() - left) * job_.piece;
  job_.run(job_.work, begin, std::min(job_.count, begin + job_.piece), thread);
  done_.fetch_add(1, std::memory_order_release);
  return true;
}

void WorkerPool::RunWorker(int thread) noexcept {
  std::uint32_t call = 0;
  while (!end_.load(std::memory_order_relaxed)) {
    call_.wait(call, std::memory_order_acquire);
    call = call_.load(std::memory_order_acquire);
    std::int64_t until = MonotonicNowNs() + kPatienceNs;
    for (int exact_queries = 1; call % 2 == 1 && call_.load(std::memory_order_relaxed) == call;
         ++exact_queries) {
      if (DoPiece(thread)) {
        exact_queries = 0;
        until = MonotonicNowNs() + kPatienceNs;
        continue;
      }
      Relax();
      if (exact_queries % kLooksAMoment == 0 && MonotonicNowNs() > until) break;
    }
  }
}

std::int64_t WorkerPool::CpuNs() const noexcept {
  std::int64_t sum = 0;
  for (const clockid_t clock : clocks_) {
    timespec t{};
    clock_gettime(clock, &t);
    sum += static_cast<std::int64_t>(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
  }
  return sum;
}

}  // namespace tandem
