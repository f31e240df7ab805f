#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace tandem {

/// Which points are given a ClearRegion in a frame. Finding one takes an exact look, ten times what
/// the sieve takes, so it is worth it if it then holds for some frames. How long regions hold
/// is known from how many there are and how many are made in a frame (Little's law): where it is
/// not worth it, one point in kProbes still gets them, to notice when it is.
///
/// Never more than a hundred or so in a frame: all that fast motion leaves behind, given one at
/// once as motion slows down, took four frames' time.
class RegionBudget {
 public:
  /// Regions made in a frame, about.
  static constexpr std::size_t kMost = 128;

  /// Whether a point of the shell may have a region at all, for now.
  bool Serves(std::uint32_t point) const noexcept { return worth_ || point % kProbes == 0; }
  /// Of `candidates` that are served and have none, one in so many is given one.
  std::size_t OneIn(std::size_t candidates) const noexcept {
    const std::size_t fresh = candidates - std::min(candidates, candidates_);
    const std::size_t unknown = std::max(unknown_, fresh) / (worth_ ? 1 : kProbes);
    const std::size_t most = worth_ ? kMost : kMost / kProbes;
    return std::max<std::size_t>(1, (unknown + most - 1) / most);
  }
  /// After a frame of `candidates`, `unknown` of which had none; `made` were given one, and `known`
  /// points, candidates or others, stood where theirs holds.
  void Count(std::size_t candidates, std::size_t unknown, std::size_t known,
             std::size_t made) noexcept {
    candidates_ = candidates;
    unknown_ = unknown;
    known_ += kNew * (static_cast<double>(known) - known_);
    made_ += kNew * (static_cast<double>(made) - made_);
    if (worth_) {
      worth_ = made_ <= kFew || known_ >= kLeastFrames * made_;
    } else if (known_ >= 2 * kLeastFrames * made_) {
      worth_ = true;
      known_ += kLeastFrames * static_cast<double>(kMost);  // until the others have theirs
    }
  }

 private:
  static constexpr std::uint32_t kProbes = 16;
  static constexpr double kNew = 1.0 / 16;  // the share of a frame in what is known of the last
  static constexpr double kLeastFrames = 8;
  static constexpr double kFew = 32;  // in a frame: always worth it

  bool worth_ = true;
  std::size_t candidates_ = 0;  // of the last frame
  std::size_t unknown_ = 0;
  double known_ = 0;  // means over the last frames
  double made_ = 0;
};

}  // namespace tandem
