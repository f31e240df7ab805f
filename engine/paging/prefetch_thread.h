#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "engine/base/spatial.h"
#include "engine/paging/voxel_arena.h"
#include "engine/realtime/spsc_queue.h"
#include "engine/realtime/triple_buffer.h"
#include "engine/voxel/map/page_source.h"

namespace tandem {

/// The box that holds all points of a pair's shell, and the shell's pose.
struct ShellBox {
  Vec3 centre = Vec3::Zero();     // in the shell's frame, m
  Vec3 half_size = Vec3::Zero();  // m
  TripleBuffer<Pose> X_VS;        // written by the haptic thread
  std::atomic<bool> there{true};  // false: the pair is not tested; written likewise
};

struct PageRequest {
  std::uint32_t record = 0;
  std::uint32_t due = 0;  // frame from which on it may be read
  bool hint = false;      // it may never be read
};
struct PageUpdate {
  std::uint32_t record = 0;
  bool there = false;  // false: there is no room for a hint
};
struct PageVerdict {
  std::uint32_t record = 0;
  bool goes = false;
};

/// The queues between the haptic thread and the pre-fetch thread.
struct PageMail {
  static constexpr std::size_t kMostAskedBack = 512;

  SpscQueue<PageRequest> requests{1U << 16U};           // to the pre-fetch thread
  SpscQueue<PageUpdate> news{1U << 12U};                // from it
  SpscQueue<std::uint32_t> asked_back{kMostAskedBack};  // from it
  SpscQueue<PageVerdict> verdicts{kMostAskedBack};      // to it
};

/// The amount of a voxmap that has been in memory, and its cost.
struct ResidentCounts {
  std::uint64_t pages_read = 0;
  std::uint64_t pages_given_up = 0;
  std::uint64_t most_pages = 0;  // greatest number at once
};

/// Brings pages into memory, the most urgent first, and gives up pages that are farthest from the
/// shells (paper §5.3). No page that is as near as a hint is given up for it.
class PrefetchThread {
 public:
  /// `boxes` may grow until Start().
  PrefetchThread(std::shared_ptr<const PageSource> source, VoxelArena& arena, PageMail& mail,
                 std::vector<std::unique_ptr<ShellBox>>& boxes);
  ~PrefetchThread();

  void Start();
  ResidentCounts counts() const noexcept;
  /// Returns why pages cannot be read any more; null while they can.
  const std::string* fault() const noexcept {
    return failed_.load(std::memory_order_acquire) ? &fault_ : nullptr;
  }
  /// Tells whether the first `requests` requests have no more effect.
  bool IsIdleAfter(std::uint64_t requests) const noexcept {
    return idle_since_taken_.load(std::memory_order_acquire) > requests;
  }

 private:
  enum class State : std::uint8_t { kAbsent, kWanted, kThere, kAskedBack };

  void Run(const std::stop_token& stop);
  void TakeMail();
  void TakeVerdicts();
  void AddRequest(const PageRequest& request);
  void Notify(const PageUpdate& news);
  /// Reads the most urgent page into page_, or refuses it; false: there is nothing to do.
  bool ReadNext(const std::stop_token& stop);
  /// Brings in the most urgent page; false: nothing can be done at present.
  bool LoadNext(const std::stop_token& stop);
  /// Gives up pages ahead of time, so that nothing waits for room.
  void EvictPages();
  void Refuse(std::uint32_t record);
  /// Asks the haptic thread to let go of the farthest pages beyond `beyond` voxels; returns their
  /// number.
  std::size_t RequestRelease(double beyond);
  /// Returns the voxels between a hyperchunk and the nearest shell's box.
  double DistanceOf(std::uint32_t record) const;

  std::shared_ptr<const PageSource> source_;
  VoxelArena* arena_;
  PageMail* mail_;
  std::vector<std::unique_ptr<ShellBox>>* boxes_;
  std::vector<GridIndex> place_of_;   // per record: hyperchunk, from V's origin
  std::vector<State> state_;          // per record
  std::vector<PageRequest> wanted_;   // a heap
  std::vector<std::uint32_t> there_;  // records with a page in the arena
  std::vector<PageUpdate> unsent_;    // news for which the mail has no room
  std::vector<Pose> X_SV_;            // per box
  VoxelPage page_;
  std::optional<PageRequest> waiting_;  // request whose page was read and waits for room
  std::size_t asked_back_ = 0;
  bool starving_ = false;           // the haptic thread keeps all pages in memory
  std::vector<std::uint8_t> kept_;  // per record: asked back, and kept by the haptic thread
  std::int64_t kept_since_ns_ = 0;
  std::int64_t next_room_ns_ = 0;
  std::uint64_t requests_taken_ = 0;
  std::size_t reserve_;  // frames

  std::atomic<std::uint64_t> pages_read_{0};
  std::atomic<std::uint64_t> pages_given_up_{0};
  std::atomic<std::uint64_t> most_pages_{0};
  /// One more than the number of requests taken when they had no more effect; 0: never yet.
  std::atomic<std::uint64_t> idle_since_taken_{0};
  std::atomic<bool> failed_{false};
  std::string fault_;  // written before failed_
  std::jthread thread_;
};

}  // namespace tandem
