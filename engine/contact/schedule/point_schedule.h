#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/contact/schedule/block_drift.h"
#include "engine/contact/schedule/distance_queues.h"
#include "engine/contact/schedule/schedule.h"

namespace tandem {

/// Chooses which points of a pointshell are tested against a voxmap in a frame (paper §5, §5.1,
/// §5.2; decision 0014). It guarantees that a point whose own field reads contact is tested in that
/// frame, whatever the motion. The condition is that `travel` is never less than the pair's real
/// travel.
///
/// Blocks of points stand in queues by the distance of their nearest point. Chunks that are far
/// stand whole in queues of their own, by the gap that is certain for all their points. Allowances
/// are the certain gaps: (i - 1) s for a point that reads i voxels to contact. The point may lie at
/// the near side of its voxel, and the source at the near side of its own.
///
/// Used by one thread. Test() does not allocate. What is due is drifted and looked up in pieces,
/// which workers may take. The results are written by place in the list of what is due, and do not
/// depend on which thread took which piece.
class PointSchedule final : public Schedule {
 public:
  PointSchedule(const PointBlocks& blocks, const Voxmap& voxmap, int force_layer,
                const ScheduleOptions& options, VoxelReader* reader = nullptr);

  void Test(const Pose& X_VS, double travel) noexcept override;
  TestDemand Demand() const noexcept override;
  void SetForceLayer(int layer) noexcept override;
  /// The change counts as travel.
  void SetDisplacement(double metres) noexcept override;
  bool waits() const noexcept override { return waits_; }
  void Announce(const Pose& X_VS) noexcept override;
  void ForgetVoxels() noexcept override;

 private:
  /// A chunk queue holds chunks with at least 4 q voxels of allowance.
  static constexpr double kChunkUnit = 4.0;
  static constexpr std::size_t kPiece = 128;  // blocks of a piece, some microseconds

  double Allowance(int queue) const noexcept;  // voxels
  void TestChunks(const Pose& X_VS, double travel_voxels) noexcept;
  void TestChunk(std::size_t c, const Pose& X_VS) noexcept;
  /// Announces the voxels that a chunk's points may read before it is tested again (paper §5.3).
  void AnnounceChunk(std::size_t c, const Vec3& p_voxels, double radius, double gap) noexcept;
  /// Returns whether all voxels in which due blocks are looked up are in memory.
  bool DuePagesAreResident() noexcept;
  void Collect(const Pose& X_VS, double travel_voxels) noexcept;
  void CollectDue(double travel_voxels) noexcept;
  /// Collects what is due in a strip of the blocks, into the strip's own stretch of due_.
  void CollectStrip(std::size_t strip) noexcept;
  /// Returns the queue that a block is put back into because it has not drifted near; -1: it may be
  /// near.
  int QueueByDrift(std::uint32_t block, int thread) noexcept;
  /// Drifts the blocks due_[begin, end), looks up what may be near, and puts them into queues.
  void TestDue(std::size_t begin, std::size_t end, int thread) noexcept;
  void TestDueInParallel() noexcept;

  /// The sums of a thread's pieces of a frame.
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
  double owed_ = 0;  // travel owed since the last test besides the motion, m

  DistanceQueues blocks_in_;
  DistanceQueues chunks_in_;
  std::vector<std::uint8_t> open_;  // per chunk: its blocks stand in queues

  std::vector<std::uint16_t> lanes_;  // per block: lanes in contact when it was last looked up
  std::vector<std::uint32_t> due_;
  std::size_t due_count_ = 0;
  /// Ranges passed in this frame.
  std::array<DistanceQueues::Passed, DistanceQueues::kQueues> passed_{};
  std::array<std::size_t, DistanceQueues::kStrips> due_in_{};  // due blocks in each strip
  BlockDrift drift_;
  std::vector<Tally> tallies_;  // one for each thread
  bool shared_ = false;         // workers share this frame's work

  // for a voxmap that is in memory in part
  VoxelReader* reader_;  // null: the voxmap is in memory as a whole
  /// Per chunk: all voxels that its points may read until its next test are in memory.
  std::vector<std::uint8_t> there_;
  static constexpr GridIndex kNowhere{INT32_MIN, 0, 0};
  /// Voxels: a chunk is tested again within its side of travel and the travel of the next frame.
  static constexpr double kUntilTested = kChunkSide + 1.0;
  std::vector<GridIndex> hinted_;        // per chunk: place of the last hint, in units of kHintCell
  std::vector<std::uint32_t> chunk_of_;  // per block
  bool waits_ = false;  // due_ is collected but not tested, because voxels are missing
};

}  // namespace tandem
