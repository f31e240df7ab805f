#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/contact/schedule/point_blocks.h"
#include "engine/contact/schedule/voxmap_lookup.h"

namespace tandem {

/// Bounds how far blocks of points have drifted since their last look-up (paper §5.2, point
/// drifting). The sum of all travel may bring a block near although it moved along, round or back.
/// The drift is found from the transform of the frame of the look-up, which is kept for a while. So
/// it costs one small product instead of sixteen look-ups.
///
/// Never allocates after construction. Several threads may call DriftSinceLookup() and LookedUp()
/// at once, each for blocks of its own. One thread calls the rest.
class BlockDrift {
 public:
  /// `threads`: the greatest number of threads that call DriftSinceLookup().
  explicit BlockDrift(const PointBlocks& blocks, int threads = 1);

  /// Begins another frame, whose look-ups use `transform`.
  void Begin(const VoxelTransform& transform) noexcept;
  /// Notes that a block is looked up in this frame, and the mark of its nearest point.
  void LookedUp(std::uint32_t block, std::uint8_t nearest) noexcept {
    lookups_[block] = {frame_, nearest};
  }
  /// Prefetches what DriftSinceLookup() reads of a block.
  void Fetch(std::uint32_t block) const noexcept {
    __builtin_prefetch(&lookups_[block]);
    __builtin_prefetch(&blocks_->balls()[block]);
  }
  /// Forgets a block's look-up.
  void Forget(std::uint32_t block) noexcept { lookups_[block].frame = 0; }
  /// Forgets all look-ups: points were displaced.
  void ForgetAll() noexcept { oldest_ = frame_ + 1; }

  /// Returns the farthest that any point of the block can be from where it was looked up, voxels;
  /// infinity when that is not known. The rounding of single precision is not included. `thread`:
  /// the number of the calling thread.
  float DriftSinceLookup(std::uint32_t block, int thread = 0) noexcept;
  /// Returns the mark of the nearest point at the last look-up.
  std::uint8_t nearest(std::uint32_t block) const noexcept { return lookups_[block].nearest; }

 private:
  static constexpr std::size_t kHistory = 1024;  // frames that a drift can reach back
  struct Lookup {
    std::uint32_t frame = 0;  // 0: never
    std::uint8_t nearest = 0;
  };
  /// The change from an earlier frame's transform to this frame's, the same for all blocks looked
  /// up then.
  struct Change {
    std::uint32_t frame = 0;  // frame for which the change was computed
    std::array<float, 9> a{};
    std::array<float, 3> b{};
    float turn = 0;  // norm of a
  };

  const PointBlocks* blocks_;
  std::uint32_t frame_ = 0;
  std::uint32_t oldest_ = 1;  // first frame whose look-ups count
  std::vector<Lookup> lookups_;
  std::vector<VoxelTransform> history_;
  std::vector<Change> changes_;  // kHistory entries for each thread
};

}  // namespace tandem
