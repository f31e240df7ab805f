#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <latch>
#include <thread>
#include <vector>

#include <time.h>

#include "engine/realtime/realtime_setup.h"

namespace tandem {

/// Threads that take a share of a frame's work. One thread, the haptic thread, shares out work and
/// takes part in it. Nothing that it does here allocates, locks or reads a clock.
///
/// Work is cut into pieces, and a free thread takes the next piece. So a worker that is held up
/// delays the frame by one piece at most. Between frames workers sleep. A frame with enough work
/// wakes them once: WakeWorkers() costs a few microseconds. Then they poll for pieces without
/// sleeping until ReleaseWorkers(), or until none has come for kPatienceNs.
class WorkerPool {
 public:
  struct Options {
    int threads = 1;    // threads that share the work, including the calling thread
    int priority = 30;  // priority under SCHED_FIFO, as the haptic thread's; 0: ordinary threads
  };
  static constexpr int kMostThreads = 16;
  static constexpr std::int64_t kPatienceNs = 300'000;

  /// Returns once all workers run. Starts no more threads than there are processors.
  explicit WorkerPool(const Options& options);
  /// Ends and joins them.
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// Returns the number of threads that share the work, including the calling thread.
  int threads() const noexcept { return static_cast<int>(workers_.size()) + 1; }
  /// Returns the status of the worker that was granted least; without workers: all granted.
  const RealtimeStatus& realtime() const noexcept { return realtime_; }

  /// Wakes the workers, if this frame has not done so.
  void WakeWorkers() noexcept;
  /// Tells the workers that the frame has nothing more to share.
  void ReleaseWorkers() noexcept;

  /// Calls work(begin, end, thread) for pieces that make up [0, count), `piece` long but for the
  /// last, in any order. They run on any of threads() threads at once, numbered from 0, the caller.
  /// Returns when all are done and their results can be read. Work must not throw or call this
  /// object.
  template <class Work>
  void ParallelFor(std::size_t count, std::size_t piece, const Work& work) noexcept {
    Run({[](const void* of, std::size_t begin, std::size_t end, int thread) {
           (*static_cast<const Work*>(of))(begin, end, thread);
         },
         &work, count, piece});
  }

  /// Returns the processor time that all workers have used so far. Not for the haptic path.
  std::int64_t CpuNs() const noexcept;

 private:
  struct Job {
    void (*run)(const void* work, std::size_t begin, std::size_t end, int thread) = nullptr;
    const void* work = nullptr;
    std::size_t count = 0;
    std::size_t piece = 1;
    std::uint32_t Pieces() const noexcept {
      return static_cast<std::uint32_t>((count + piece - 1) / piece);
    }
  };

  void Run(const Job& job) noexcept;
  /// Takes and does the next piece; returns false when there is none.
  bool DoPiece(int thread) noexcept;
  void RunWorker(int thread) noexcept;

  /// Odd while workers must poll for pieces; workers sleep on it.
  alignas(64) std::atomic<std::uint32_t> call_{0};
  std::atomic<bool> end_{false};
  /// Number of pieces not yet taken. Only a thread that took one of a job's pieces reads the job,
  /// and the job changes only when all of them are done.
  alignas(64) std::atomic<std::uint32_t> left_{0};
  Job job_;
  alignas(64) std::atomic<std::uint32_t> done_{0};

  RealtimeStatus realtime_;
  std::vector<clockid_t> clocks_;
  std::vector<std::thread> workers_;
};

}  // namespace tandem
