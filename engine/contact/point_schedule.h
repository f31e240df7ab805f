#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/contact/block_drift.h"
#include "engine/contact/distance_queues.h"
#include "engine/contact/schedule.h"

namespace tandem {

/// Which points of a pointshell are tested against a voxmap in a frame (paper §5, §5.1, §5.2;
/// decision 0014). What it guarantees: a point whose own field reads contact is tested in that
/// frame, whatever the motion, as long as `travel` is never less than what the pair really moved.
///
/// Blocks of points stand in queues by the distance of their nearest point; chunks that are far
/// stand whole in queues of their own, by the gap that is certain for all their points. Allowances
/// are the certain gaps: (i - 1) s for a point that reads i voxels to contact, since it may lie at
/// the near side of its voxel and the source at the near side of its own.
///
/// Used by one thread. Test() does not allocate. What is due is drifted and looked up in pieces,
/// which helpers may take; what that comes to is written by place in the list of what is due, and
/// put into queues by the calling thread, so nothing depends on who did what.
class PointSchedule final : public Schedule {
 public:
  PointSchedule(const PointBlocks& blocks, const Voxmap& voxmap, int force_layer,
                const ScheduleOptions& options, VoxelReader* reader = nullptr);

  void Test(const Pose& X_VS, double travel) noexcept override;
  TestLoad Load() const noexcept override;
  void SetForceLayer(int layer) noexcept override;
  /// Counts as travel.
  void SetDisplacement(double metres) noexcept override;
  bool waits() const noexcept override { return waits_; }
  void Announce(const Pose& X_VS) noexcept override;
  void ForgetVoxels() noexcept override;

 private:
  /// A chunk queue holds chunks with at least 4 q voxels of allowance.
  static constexpr double kChunkUnit = 4.0;
  static constexpr std::size_t kPiece = 128;  // blocks, some microseconds

  double Allowance(int queue) const noexcept;  // voxels
  void TestChunks(const Pose& X_VS, double travel_voxels) noexcept;
  void TestChunk(std::size_t c, const Pose& X_VS) noexcept;
  /// Says which voxels a chunk's points may read before it is tested again (paper §5.3).
  void AnnounceChunk(std::size_t c, const Vec3& p_voxels, double radius, double gap) noexcept;
  /// Tells whether all voxels are in memory that due blocks are looked up in.
  bool DueIsThere() noexcept;
  void Collect(const Pose& X_VS, double travel_voxels) noexcept;
  void CollectDue(double travel_voxels) noexcept;
  /// What is due in a strip of the blocks, into the strip's own stretch of due_.
  void CollectStrip(std::size_t strip) noexcept;
  /// The queue that a block is put back into because it has not drifted near; -1: it may be near.
  int QueueByDrift(std::uint32_t block, int thread) noexcept;
  /// Drifts the blocks due_[begin, end), looks up what may be near, and puts them into queues.
  void TestDue(std::size_t begin, std::size_t end, int thread) noexcept;
  void ShareDue() noexcept;

  /// What a thread's pieces of a frame came to.
  struct alignas(64) Tally {
    TestCounts counts;
    DistanceQueues::Moves moves{};
  };
  void PutDue(std::uint32_t block, int queue, Tally& tally) noexcept {
    if (shared_) {
      blocks_in_.PutBeside(block, queue, tally.moves);
    } else {
      blocks_in_.Put(block, queue);
    }
  }

  ScheduleOptions options_;
  double owed_ = 0;  // m of travel since the last test, besides the motion

  DistanceQueues blocks_in_;
  DistanceQueues chunks_in_;
  std::vector<std::uint8_t> open_;  // per chunk: its blocks stand in queues

  std::vector<std::uint16_t> lanes_;  // of each block, in contact when it was last looked up
  std::vector<std::uint32_t> due_;
  std::size_t due_count_ = 0;
  std::array<DistanceQueues::Passed, DistanceQueues::kQueues> passed_{};  // in this frame
  std::array<std::size_t, DistanceQueues::kStrips> due_in_{};             // each strip
  BlockDrift drift_;
  std::vector<Tally> tallies_;  // of each thread
  bool shared_ = false;         // this frame's work, among them

  // of a voxmap that is in memory in part
  VoxelReader* reader_;              // null: it is there as a whole
  std::vector<std::uint8_t> there_;  // per chunk: all that its points may read until it is tested
  static constexpr GridIndex kNowhere{INT32_MIN, 0, 0};
  /// Voxels: a chunk is tested again within its side of travel, and what the frame then goes.
  static constexpr double kUntilTested = kChunkSide + 1.0;
  std::vector<GridIndex> hinted_;        // per chunk: where, in units of kHintCell
  std::vector<std::uint32_t> chunk_of_;  // per block
  bool waits_ = false;                   // due_ is collected, and not tested for want of voxels
};

}  // namespace tandem
