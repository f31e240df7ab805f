#include "engine/contact/schedule/schedule.h"

#include <algorithm>

#include "engine/base/check.h"
#include "engine/contact/schedule/point_schedule.h"

namespace tandem {

Schedule::Schedule(const PointBlocks& blocks, const Voxmap& voxmap, int force_layer)
    : blocks_(&blocks),
      voxmap_(&voxmap),
      s_(voxmap.voxel_size()),
      place_error_(0),
      range_(voxmap.range()),
      layer_(force_layer),
      contacts_(blocks.size()) {
  CheckForceLayer(force_layer);
  double reach = 0;  // greatest distance of the shell's points from its frame's origin, m
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const PointBlocks::Ball& ball = blocks.balls()[b];
    TANDEM_CHECK(2 * ball.radius < kWidestBlock * s_);
    reach = std::max<double>(reach, Vec3f(ball.x, ball.y, ball.z).norm() + ball.radius);
  }
  place_error_ = PlaceError((voxmap.extent().maxCoeff() + reach) / s_);
}

void Schedule::CheckForceLayer(int layer) const noexcept {
  TANDEM_CHECK(layer >= 0 && layer <= std::max(0, range_ - 2));
}

void Schedule::SortContacts() noexcept {
  std::sort(contacts_.begin(), contacts_.begin() + static_cast<std::ptrdiff_t>(contact_count_),
            [](const ContactBlock& a, const ContactBlock& b) {
              return a.block < b.block;
            });
}

std::unique_ptr<Schedule> MakeSchedule(const PointBlocks& blocks, const Voxmap& voxmap,
                                       int force_layer, const ScheduleOptions& options,
                                       VoxelReader* reader) {
  if (options.instead != nullptr) {
    TANDEM_CHECK(reader == nullptr);
    return options.instead(blocks, voxmap, force_layer, options);
  }
  return std::make_unique<PointSchedule>(blocks, voxmap, force_layer, options, reader);
}

}  // namespace tandem
