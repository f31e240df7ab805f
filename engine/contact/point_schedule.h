#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/contact/block_drift.h"
#include "engine/contact/block_test.h"
#include "engine/contact/distance_queues.h"
#include "engine/contact/max_travel.h"
#include "engine/contact/point_blocks.h"
#include "engine/voxel/voxmap.h"

namespace tandem {

/// Which of the paper's savings are in use; all of them, but for comparisons.
struct ScheduleOptions {
  bool coherence = true;  // §5: distance queues; without, every awake point in every frame
  bool chunks = true;     // §5.1: whole chunks by their centre while they are far
  bool drift = true;      // §5.2: a block that has not drifted near is not looked up
};

/// What a frame's tests came to.
struct TestCounts {
  std::size_t looked_up = 0;  // points
  std::size_t drifted = 0;    // points of blocks that were put back by their drift alone
  std::size_t chunks = 0;     // chunk centres
  TestCounts& operator+=(const TestCounts& other) {
    looked_up += other.looked_up;
    drifted += other.drifted;
    chunks += other.chunks;
    return *this;
  }
};

/// Which points of a pointshell are tested against a voxmap in a frame (paper §5, §5.1, §5.2;
/// VPS.md §5 to §8). What it guarantees: a point whose own field reads contact is tested in that
/// frame, whatever the motion, as long as `travel` is never less than what the pair really moved.
///
/// Blocks of points stand in queues by the distance of their nearest point; chunks that are far
/// stand whole in queues of their own, by the gap that is certain for all their points. Allowances
/// are the certain gaps: (i - 1) s for a point that reads i voxels to contact, since it may lie at
/// the near side of its voxel and the source at the near side of its own.
///
/// Used by one thread. Test() does not allocate.
class PointSchedule {
 public:
  PointSchedule(const PointBlocks& blocks, const Voxmap& voxmap, int force_layer,
                const ScheduleOptions& options);

  /// Tests what has come due: `travel` is the most that any surface points of the two bodies can
  /// have come nearer since the last call, m.
  void Test(const Pose& X_VS, double travel) noexcept;

  /// The blocks with points in contact, in order, as of the last Test().
  struct ContactBlock {
    std::uint32_t block;
    std::uint16_t lanes;
  };
  std::span<const ContactBlock> contacts() const noexcept {
    return {contacts_.data(), contact_count_};
  }
  /// What the last Test() took points to voxels with.
  const VoxelTransform& transform() const noexcept { return transform_; }
  const TestCounts& counts() const noexcept { return counts_; }

  /// What the next frames will owe.
  TestLoad Load() const noexcept;

  int force_layer() const noexcept { return layer_; }
  /// Takes effect with the next Test().
  void SetForceLayer(int layer) noexcept;
  /// Shifts all points along their inward normals by `metres` from now on; counts as travel.
  void SetDisplacement(double metres) noexcept;
  double displacement() const noexcept { return displacement_; }

  const DistanceQueues& block_queues() const noexcept { return blocks_in_; }
  const DistanceQueues& chunk_queues() const noexcept { return chunks_in_; }

 private:
  /// A chunk queue holds chunks with at least 4 q voxels of allowance.
  static constexpr double kChunkUnit = 4.0;
  /// Of a voxel, off every allowance: single-precision places err by less.
  static constexpr double kRounding = 0.004;

  double Allowance(int queue) const noexcept;  // voxels
  int QueueOf(int mark) const noexcept;
  int highest_queue() const noexcept { return std::min(range_ + 1 - layer_, 15); }
  void TestChunks(const Pose& X_VS, double travel_voxels) noexcept;
  void TestChunk(std::size_t c, const Pose& X_VS) noexcept;
  void CollectDue(double travel_voxels) noexcept;
  bool StillFar(std::uint32_t block) noexcept;

  const PointBlocks* blocks_;
  const Voxmap* voxmap_;
  ScheduleOptions options_;
  double s_;
  int range_;
  int layer_;
  double displacement_ = 0;  // m
  double owed_ = 0;          // m of travel since the last test, besides the motion

  DistanceQueues blocks_in_;
  DistanceQueues chunks_in_;
  std::vector<std::uint8_t> open_;  // per chunk: its blocks stand in queues

  VoxelTransform transform_;
  std::vector<std::uint32_t> due_;
  std::vector<BlockReading> readings_;
  std::vector<ContactBlock> contacts_;
  std::size_t due_count_ = 0;
  std::size_t contact_count_ = 0;
  TestCounts counts_;

  BlockDrift drift_;
};

}  // namespace tandem
