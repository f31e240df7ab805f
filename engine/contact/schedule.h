#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "engine/contact/block_test.h"
#include "engine/contact/max_travel.h"
#include "engine/contact/point_blocks.h"
#include "engine/realtime/frame_helpers.h"
#include "engine/voxel/voxmap.h"

namespace tandem {

class VoxelReader;

/// Which of the paper's savings are in use; all of them, but for comparisons. And who helps.
struct ScheduleOptions {
  bool coherence = true;  // §5: distance queues; without, every awake point in every frame
  bool chunks = true;     // §5.1: whole chunks by their centre while they are far
  bool drift = true;      // §5.2: what has not drifted near is not looked up
  bool printed = false;   // by Eqn. 2 and 3 to the letter, which can be late; for comparisons
  /// Share large frames' work, to the same bits; null: the calling thread does all. Must outlive
  /// whoever is given it.
  FrameHelpers* helpers = nullptr;
  /// Blocks due in a frame from which on helpers are called: about 50 us of one thread.
  std::size_t shared_from = 1500;
};

/// What a frame's tests came to.
struct TestCounts {
  std::size_t looked_up = 0;  // points
  std::size_t drifted = 0;    // points that were put back by their drift alone
  std::size_t chunks = 0;     // chunk centres
  std::size_t compared = 0;   // what it cost to tell sharp edges apart, in points

  /// Counts what a frame's capacity is measured in; chunks are not.
  double tests() const noexcept { return static_cast<double>(looked_up + drifted + compared); }
  TestCounts& operator+=(const TestCounts& other) {
    looked_up += other.looked_up;
    drifted += other.drifted;
    chunks += other.chunks;
    compared += other.compared;
    return *this;
  }
};

/// Which points of a pointshell are tested against a voxmap in a frame (paper §5, §5.1, §5.2), and
/// which of these are in contact. Called once a frame; used by one thread, which may have helpers;
/// no call allocates.
class Schedule {
 public:
  virtual ~Schedule() = default;
  Schedule(const Schedule&) = delete;
  Schedule& operator=(const Schedule&) = delete;

  /// Tests what has come due: `travel` is the most that any surface points of the two bodies can
  /// have come nearer since the last call, m.
  virtual void Test(const Pose& X_VS, double travel) noexcept = 0;
  /// How far the two bodies may come towards one another before the next Test(), m. Only the
  /// printed rule counts by it; ours counts by what was really travelled.
  virtual void LimitTravel(double /*metres*/) noexcept {}
  /// What the next frames will owe.
  virtual TestLoad Load() const noexcept = 0;
  /// Takes effect with the next Test().
  virtual void SetForceLayer(int layer) noexcept = 0;
  /// Shifts all points along their inward normals by `metres` from now on.
  virtual void SetDisplacement(double metres) noexcept = 0;

  /// Tells whether the last Test() could not be made, because voxels were not in memory: the bodies
  /// are to stand, and the next one goes on with it.
  virtual bool waits() const noexcept { return false; }
  /// Says which voxels will be read where the shell stands, before the first Test().
  virtual void Announce(const Pose& /*X_VS*/) noexcept {}
  /// Forgets what was announced: the pair is not tested for a while.
  virtual void ForgetVoxels() noexcept {}

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
  /// Voxels that the places of points may err by.
  double place_error() const noexcept { return place_error_; }
  int force_layer() const noexcept { return layer_; }
  double displacement() const noexcept { return displacement_; }

 protected:
  Schedule(const PointBlocks& blocks, const Voxmap& voxmap, int force_layer);

  /// Beyond the field's range all is one queue.
  int highest_queue() const noexcept { return std::min(range_ + 1 - layer_, 15); }
  /// The queue of a point that reads `mark`: its voxels to contact.
  int QueueOf(int mark) const noexcept { return std::clamp(mark - 2 - layer_, 0, highest_queue()); }
  void CheckForceLayer(int layer) const noexcept;
  void SortContacts() noexcept;

  const PointBlocks* blocks_;
  const Voxmap* voxmap_;
  double s_;            // voxel size, m
  double place_error_;  // voxels
  int range_;
  int layer_;
  double displacement_ = 0;  // m
  VoxelTransform transform_;
  std::vector<ContactBlock> contacts_;
  std::size_t contact_count_ = 0;
  TestCounts counts_;
};

/// PointSchedule, or PrintedSchedule if the options say so. `blocks`, `voxmap` and `reader` must
/// outlive it. `reader`: of a voxmap that is in memory in part; null of a whole one, which the
/// printed schedule needs.
std::unique_ptr<Schedule> MakeSchedule(const PointBlocks& blocks, const Voxmap& voxmap,
                                       int force_layer, const ScheduleOptions& options,
                                       VoxelReader* reader = nullptr);

}  // namespace tandem
