#include "app/bench/measure/all_points.h"

#include <algorithm>
#include <bit>
#include <numeric>

namespace tandem {

namespace {

/// Voxels; a point that is this far from all of the fixture has nothing near it. A field tells only
/// that for places some voxels away.
constexpr int kNothingNear = 1;

}  // namespace

AllPoints::AllPoints(const World& world) : world_(&world) {
  if (!plain()) return;
  all_.resize(world.point_pair(0).blocks().size());
  readings_.resize(all_.size());
  tested_.resize(all_.size());
  std::iota(all_.begin(), all_.end(), 0U);
}

std::size_t AllPoints::count() const noexcept {
  return plain() ? world_->model().bodies[0].points.size() : world_->field_pair(0).point_count();
}

void AllPoints::Remember() {
  X_WB_ = world_->state(0).X_WB;
}

std::size_t AllPoints::Violations() {
  return plain() ? PlainViolations() : world_->field_pair(0).CountUnfound({X_WB_, {}}, {});
}

std::size_t AllPoints::PlainViolations() {
  const ContactPair& pair = world_->point_pair(0);
  const Schedule& schedule = pair.schedule();
  TestBlocks(pair.blocks(), schedule.transform(), pair.voxmap(), 2 + schedule.force_layer(), all_,
             readings_.data());
  std::fill(tested_.begin(), tested_.end(), std::uint16_t{0});
  for (const auto& contact : schedule.contacts()) tested_[contact.block] = contact.lanes;
  std::size_t count = 0;
  for (std::size_t b = 0; b < all_.size(); ++b) {
    const unsigned wrong = readings_[b].contacts ^ tested_[b];
    count += static_cast<std::size_t>(std::popcount(wrong));
  }
  return count;
}

bool AllPoints::AllBeyond(const Pose& X_WB) {
  const WorldModel& model = world_->model();
  if (!plain()) {
    FieldPair pair(model.bodies[0].surface, model.fixture_surface, {}, {});
    return pair.Read({X_WB, {}}, {}).nearest_voxels >= kNothingNear;
  }
  const Voxmap& voxmap = world_->point_pair(0).voxmap();
  const Pose X_VS = Pose{Quat::Identity(), -voxmap.p_WVo()} * X_WB;
  TestBlocks(world_->point_pair(0).blocks(), VoxelTransform(X_VS, voxmap.voxel_size(), 0), voxmap,
             0, all_, readings_.data());
  return std::all_of(readings_.begin(), readings_.end(), [&](const BlockReading& reading) {
    return reading.nearest >= voxmap.beyond();
  });
}

}  // namespace tandem
