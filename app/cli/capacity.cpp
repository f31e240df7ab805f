#include "app/cli/capacity.h"

#include <algorithm>

#include "engine/contact/schedule.h"
#include "engine/realtime/clock.h"
#include "engine/world/step_inputs.h"

namespace tandem {

namespace {
constexpr std::uint32_t kStride = 7;  // of the blocks tested: those that come due are scattered
constexpr std::int64_t kLongEnoughNs = 20'000'000;
constexpr double kQueueShare = 1.3;  // of a frame's time, to that of the tests alone
}  // namespace

double MeasureCapacity(const WorldModel& world, double seconds) {
  const BodyModel* largest = nullptr;
  for (const BodyModel& body : world.bodies) {
    if (largest == nullptr || body.points.size() > largest->points.size()) largest = &body;
  }
  const Voxmap& voxmap = world.has_fixture ? world.fixture : world.bodies[0].voxmap;
  if (largest == nullptr || voxmap.empty() || largest->points.size() == 0) return kDefaultCapacity;
  const PointBlocks blocks(largest->points);
  const Pose X_VS = Pose{Quat::Identity(), voxmap.p_WVo()}.Inverse() * largest->X_WB0;
  const VoxelTransform transform(X_VS, voxmap.voxel_size(), 0);
  std::vector<std::uint32_t> list;
  for (std::uint32_t b = 0; b < blocks.size(); b += kStride) list.push_back(b);
  std::vector<BlockReading> readings(list.size());
  LoopClock& clock = MachineClock();
  double points = 0;
  const std::int64_t begin = clock.ThreadCpuNs();
  std::int64_t spent = 0;
  do {
    TestBlocks(blocks, transform, voxmap, 3, list, readings.data());
    points += static_cast<double>(PointBlocks::kLanes * list.size());
    spent = clock.ThreadCpuNs() - begin;
  } while (spent < kLongEnoughNs);
  const double each = 1e-9 * static_cast<double>(spent) / points;
  return std::max(1000.0, seconds / (kQueueShare * each));
}

}  // namespace tandem
