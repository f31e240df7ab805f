#include "engine/contact/schedule/block_drift.h"

#include <cmath>
#include <limits>

namespace tandem {

BlockDrift::BlockDrift(const PointBlocks& blocks, int threads)
    : blocks_(&blocks),
      lookups_(blocks.size()),
      history_(kHistory),
      changes_(kHistory * static_cast<std::size_t>(threads)) {}

void BlockDrift::Begin(const VoxelTransform& transform) noexcept {
  ++frame_;
  history_[frame_ % kHistory] = transform;
}

float BlockDrift::DriftSinceLookup(std::uint32_t b, int thread) noexcept {
  const Lookup& lookup = lookups_[b];
  if (lookup.frame < oldest_ || frame_ - lookup.frame >= kHistory) {
    return std::numeric_limits<float>::infinity();
  }
  Change& change = changes_[static_cast<std::size_t>(thread) * kHistory + lookup.frame % kHistory];
  if (change.frame != frame_) {
    const VoxelTransform& now = history_[frame_ % kHistory];
    const VoxelTransform& then = history_[lookup.frame % kHistory];
    float square = 0;
    for (std::size_t k = 0; k < 9; ++k) {
      change.a[k] = now.a[k] - then.a[k];
      square += change.a[k] * change.a[k];
    }
    for (std::size_t k = 0; k < 3; ++k) change.b[k] = now.b[k] - then.b[k];
    change.turn = std::sqrt(square);
    change.frame = frame_;
  }
  const PointBlocks::Ball& ball = blocks_->balls()[b];
  const auto& a = change.a;
  const float dx = a[0] * ball.x + a[1] * ball.y + a[2] * ball.z + change.b[0];
  const float dy = a[3] * ball.x + a[4] * ball.y + a[5] * ball.z + change.b[1];
  const float dz = a[6] * ball.x + a[7] * ball.y + a[8] * ball.z + change.b[2];
  return std::sqrt(dx * dx + dy * dy + dz * dz) + change.turn * ball.radius;
}

}  // namespace tandem
