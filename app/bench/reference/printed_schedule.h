#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "engine/contact/schedule/distance_queues.h"
#include "engine/contact/schedule/schedule.h"

namespace tandem {

/// The schedule as the paper prints it (§5, §5.1, §5.2), for comparison with PointSchedule. It can
/// be late (docs/decisions/0014-schedule.md). The product does not use it.
///
/// A point stands in the queue of its voxels to contact, i. Queue 0 is tested in every frame. From
/// a queue of n_i points, Eqn. 3's m_i = MaxTravel n_i / (0.5 s i), rounded up, are tested round
/// robin. Chunks are tested likewise by their centres in the surface's chunk-level field, in units
/// of a chunk. A point that falls due leaves its queue for a lower one by each whole voxel of its
/// drift, and is looked up two queues from contact.
///
/// Where the paper leaves a choice, this class takes the careful one. A chunk is far from two
/// chunks off on. The points of a chunk that comes near are all tested at once. Half a hyperchunk a
/// frame is allowed only when all chunks are beyond their field. A new force layer or displacement
/// has everything tested anew.
class PrintedSchedule final : public Schedule {
 public:
  PrintedSchedule(const PointBlocks& blocks, const Voxmap& voxmap, int force_layer,
                  const ScheduleOptions& options);

  void Test(const Pose& X_VS, double travel) noexcept override;
  void LimitTravel(double metres) noexcept override { limit_ = metres; }
  TestDemand Demand() const noexcept override;
  void SetForceLayer(int layer) noexcept override;
  void SetDisplacement(double metres) noexcept override;

 private:
  static constexpr double kShare = 0.5;     // allowance for each voxel, or chunk, of distance
  static constexpr int kFarthestChunk = 8;  // queue of chunks that read beyond

  void TestAnew() noexcept;
  void TestChunks(const Pose& X_VS, double most) noexcept;
  void TestChunk(std::size_t c, const Pose& X_VS) noexcept;
  void CollectDue(DistanceQueues& queues, bool coherence, double most) noexcept;
  bool StillFar(std::uint32_t address, const std::array<float, 3>& p_V) noexcept;
  void LookUpAll(Field field) noexcept;

  ScheduleOptions options_;
  double limit_ = 0;  // m

  // a point's address is 16 times its block's number, and its lane
  DistanceQueues points_in_;
  DistanceQueues chunks_in_;
  std::vector<std::uint8_t> open_;  // per chunk: its points stand in queues
  std::vector<std::uint32_t> due_;
  std::size_t due_count_ = 0;

  /// The points to look up in one field.
  struct List {
    std::vector<std::uint32_t> addresses;
    std::vector<float> x, y, z;  // voxels of V
    std::size_t count = 0;
  };
  std::array<List, kFields> lists_;
  std::vector<std::uint8_t> marks_;
  std::vector<std::uint16_t> lanes_;  // per block: lanes in contact

  /// The place of a point's last look-up, in voxels of V, and the queue that it led to.
  struct Lookup {
    std::array<float, 3> p_V{};
    std::uint8_t queue = 0;
  };
  std::vector<Lookup> lookups_;
};

/// Makes a printed schedule, for ScheduleOptions::instead.
std::unique_ptr<Schedule> MakePrintedSchedule(const PointBlocks& blocks, const Voxmap& voxmap,
                                              int force_layer, const ScheduleOptions& options);

}  // namespace tandem
