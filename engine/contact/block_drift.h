#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/contact/block_test.h"
#include "engine/contact/point_blocks.h"

namespace tandem {

/// How far blocks of points have drifted since they were last looked up (paper §5.2, point
/// drifting). A block that came near by the sum of all travel may have moved along, round or back;
/// where it stood is known from its frame's transform, kept for a while, so its drift costs one
/// small product instead of sixteen look-ups.
///
/// Never allocates after construction. Of() and LookedUp() may be called by several threads at
/// once, each for blocks of its own; the rest by one.
class BlockDrift {
 public:
  /// `threads`: the most that will use it at once.
  explicit BlockDrift(const PointBlocks& blocks, int threads = 1);

  /// Another frame begins, with the transform that its look-ups will be made with.
  void Begin(const VoxelTransform& transform) noexcept;
  /// A block was looked up in this frame, its nearest point's mark read.
  void LookedUp(std::uint32_t block, std::uint8_t nearest) noexcept {
    lookups_[block] = {frame_, nearest};
  }
  /// Of() will be asked of a block soon.
  void Fetch(std::uint32_t block) const noexcept {
    __builtin_prefetch(&lookups_[block]);
    __builtin_prefetch(&blocks_->balls()[block]);
  }
  /// What is known of a block no longer counts.
  void Forget(std::uint32_t block) noexcept { lookups_[block].frame = 0; }
  /// Nothing that is known counts any longer: points were displaced.
  void ForgetAll() noexcept { oldest_ = frame_ + 1; }

  /// The most that any point of the block can be from where it was looked up, in voxels; infinity
  /// when that is not known. Less the rounding of single precision. `thread`: the calling one's
  /// number.
  float Of(std::uint32_t block, int thread = 0) noexcept;
  /// The mark that was read then.
  std::uint8_t nearest(std::uint32_t block) const noexcept { return lookups_[block].nearest; }

 private:
  static constexpr std::size_t kHistory = 1024;  // frames that a drift can reach back
  struct Lookup {
    std::uint32_t frame = 0;  // 0: never
    std::uint8_t nearest = 0;
  };
  /// Between an earlier frame's transform and this one's: the same for all blocks looked up then.
  struct Change {
    std::uint32_t frame = 0;  // for which it was computed
    std::array<float, 9> a{};
    std::array<float, 3> b{};
    float turn = 0;  // norm of a
  };

  const PointBlocks* blocks_;
  std::uint32_t frame_ = 0;
  std::uint32_t oldest_ = 1;  // earlier look-ups do not count
  std::vector<Lookup> lookups_;
  std::vector<VoxelTransform> history_;
  std::vector<Change> changes_;  // kHistory of each thread
};

}  // namespace tandem
