#include "app/cli/all_points.h"

#include <algorithm>
#include <bit>
#include <numeric>

namespace tandem {

AllPoints::AllPoints(const ContactPair& pair)
    : pair_(&pair), all_(pair.blocks().size()), readings_(all_.size()), tested_(all_.size()) {
  std::iota(all_.begin(), all_.end(), 0U);
}

std::size_t AllPoints::Violations() {
  const Schedule& schedule = pair_->schedule();
  TestBlocks(pair_->blocks(), schedule.transform(), pair_->voxmap(), 2 + schedule.force_layer(),
             all_, readings_.data());
  std::fill(tested_.begin(), tested_.end(), std::uint16_t{0});
  for (const auto& contact : schedule.contacts()) tested_[contact.block] = contact.lanes;
  std::size_t count = 0;
  for (std::size_t b = 0; b < all_.size(); ++b) {
    const unsigned wrong = readings_[b].contacts ^ tested_[b];
    count += static_cast<std::size_t>(std::popcount(wrong));
  }
  return count;
}

bool AllPoints::AllBeyond(const Pose& X_VS) {
  const Voxmap& voxmap = pair_->voxmap();
  TestBlocks(pair_->blocks(), VoxelTransform(X_VS, voxmap.voxel_size(), 0), voxmap, 0, all_,
             readings_.data());
  return std::all_of(readings_.begin(), readings_.end(), [&](const BlockReading& reading) {
    return reading.nearest >= voxmap.beyond();
  });
}

}  // namespace tandem
