#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "engine/base/experiment_options.h"
#include "engine/contact/schedule/max_travel.h"
#include "engine/contact/schedule/point_blocks.h"
#include "engine/contact/schedule/voxmap_lookup.h"
#include "engine/realtime/worker_pool.h"
#include "engine/voxel/map/voxmap.h"

namespace tandem {

class Schedule;
class VoxelReader;
struct ScheduleOptions;

/// Makes a schedule of another kind than ours.
using ScheduleMaker = std::unique_ptr<Schedule> (*)(const PointBlocks& blocks, const Voxmap& voxmap,
                                                    int force_layer,
                                                    const ScheduleOptions& options);

/// The threads that help with a frame, and the experiments.
struct ScheduleOptions {
  /// Threads that share the work of large frames, with the same bits; null: the calling thread does
  /// all. They must outlive the schedule.
  WorkerPool* workers = nullptr;
  /// Blocks due in a frame from which on workers are called: about 50 us of one thread.
  std::size_t shared_from = 1500;
  ExperimentOptions experiments{};
  /// Makes the schedule that is used in place of ours, to compare with; null: ours.
  ScheduleMaker instead = nullptr;
};

/// The counts of a frame's tests.
struct TestCounts {
  std::size_t looked_up = 0;  // points
  std::size_t drifted = 0;    // points put back by their drift alone
  std::size_t chunks = 0;     // chunk centres
  std::size_t compared = 0;   // cost of telling sharp edges apart, in points

  /// Returns the tests that count against a frame's capacity; chunks do not.
  double tests() const noexcept { return static_cast<double>(looked_up + drifted + compared); }
  TestCounts& operator+=(const TestCounts& other) {
    looked_up += other.looked_up;
    drifted += other.drifted;
    chunks += other.chunks;
    compared += other.compared;
    return *this;
  }
};

/// Chooses which points of a pointshell are tested against a voxmap in a frame (paper §5, §5.1,
/// §5.2), and finds which of these are in contact. Test() is called once a frame. Used by one
/// thread, which may have workers; no call allocates.
class Schedule {
 public:
  virtual ~Schedule() = default;
  Schedule(const Schedule&) = delete;
  Schedule& operator=(const Schedule&) = delete;

  /// Tests what has come due. `travel`: the most that surface points of the two bodies can have
  /// come nearer since the last call, m.
  virtual void Test(const Pose& X_VS, double travel) noexcept = 0;
  /// Sets how far the two bodies may come towards one another until the next Test(), m. Only the
  /// printed rule counts by it; PointSchedule counts by the real travel.
  virtual void LimitTravel(double /*metres*/) noexcept {}
  /// Returns what the next frames will owe.
  virtual TestDemand Demand() const noexcept = 0;
  /// Sets the force layer from the next Test() on.
  virtual void SetForceLayer(int layer) noexcept = 0;
  /// Shifts all points along their inward normals by `metres` from the next Test() on.
  virtual void SetDisplacement(double metres) noexcept = 0;

  /// Tells whether the last Test() could not be made because voxels were not in memory. Then the
  /// bodies must stand still, and the next Test() goes on with it.
  virtual bool waits() const noexcept { return false; }
  /// Announces the voxels that will be read where the shell stands, before the first Test().
  virtual void Announce(const Pose& /*X_VS*/) noexcept {}
  /// Forgets what was announced: the pair is not tested for a while.
  virtual void ForgetVoxels() noexcept {}

  /// A block with points in contact. contacts() has them in order, as of the last Test().
  struct ContactBlock {
    std::uint32_t block;
    std::uint16_t lanes;
  };
  std::span<const ContactBlock> contacts() const noexcept {
    return {contacts_.data(), contact_count_};
  }
  /// Returns the transform from points to voxels in the last Test().
  const VoxelTransform& transform() const noexcept { return transform_; }
  const TestCounts& counts() const noexcept { return counts_; }
  /// Returns the greatest error of a point's place, voxels.
  double place_error() const noexcept { return place_error_; }
  int force_layer() const noexcept { return layer_; }
  double displacement() const noexcept { return displacement_; }

 protected:
  Schedule(const PointBlocks& blocks, const Voxmap& voxmap, int force_layer);

  /// All distances beyond the field's range share one queue.
  int highest_queue() const noexcept { return std::min(range_ + 1 - layer_, 15); }
  /// Returns the queue of a point that reads `mark`: its voxels to contact.
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

/// Makes a PointSchedule, or what `options.instead` makes. `blocks`, `voxmap` and
/// `reader` must outlive it. `reader` is for a voxmap of which a part is in memory, and null for a
/// whole one, which a schedule of another kind needs.
std::unique_ptr<Schedule> MakeSchedule(const PointBlocks& blocks, const Voxmap& voxmap,
                                       int force_layer, const ScheduleOptions& options,
                                       VoxelReader* reader = nullptr);

}  // namespace tandem
