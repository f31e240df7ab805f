#include "app/cli/capacity.h"

#include <algorithm>

#include "engine/contact/schedule.h"
#include "engine/realtime/clock.h"
#include "engine/world/step_inputs.h"

namespace tandem {

namespace {
constexpr std::uint32_t kStride = 7;  // of the blocks tested: those that come due are scattered
constexpr std::size_t kPiece = 128;   // of them, that one thread takes at a time
constexpr std::int64_t kLongEnoughNs = 20'000'000;
constexpr double kQueueShare = 1.3;  // of a frame's time, to that of the tests alone
}  // namespace

double MeasureCapacity(const WorldModel& world, double seconds, FrameHelpers* helpers) {
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
  const auto test = [&](std::size_t begin, std::size_t end, int) {
    TestBlocks(blocks, transform, voxmap, 3, std::span(list).subspan(begin, end - begin),
               readings.data() + begin);
  };
  LoopClock& clock = MachineClock();
  // with helpers what counts is when all have done, and the middle round, for one may be held up
  std::vector<double> rounds;
  const std::int64_t begin = clock.NowNs();
  const std::int64_t cpu_begin = clock.ThreadCpuNs();
  std::int64_t spent = 0;
  while (spent < kLongEnoughNs) {
    const std::int64_t round = clock.NowNs();
    if (helpers != nullptr) {
      helpers->Summon();
      helpers->Share(list.size(), kPiece, test);
      helpers->Dismiss();
    } else {
      test(0, list.size(), 0);
    }
    rounds.push_back(static_cast<double>(clock.NowNs() - round));
    spent = helpers != nullptr ? clock.NowNs() - begin : clock.ThreadCpuNs() - cpu_begin;
  }
  double each = 1e-9 / static_cast<double>(PointBlocks::kLanes * list.size());
  if (helpers != nullptr) {
    const auto middle = rounds.begin() + static_cast<std::ptrdiff_t>(rounds.size() / 2);
    std::nth_element(rounds.begin(), middle, rounds.end());
    each *= *middle;
  } else {
    each *= static_cast<double>(spent) / static_cast<double>(rounds.size());
  }
  return std::max(1000.0, seconds / (kQueueShare * each));
}

}  // namespace tandem
