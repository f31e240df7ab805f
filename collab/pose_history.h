#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "collab/partner.h"

namespace tandem {

/// Where the instances of a shared body were in the last kSeconds, as they were known here: ours,
/// and the others' as heard. Moments are counted from 0 and kept kPeriod frames apart. Nothing
/// allocates after construction.
class PoseHistory {
 public:
  static constexpr std::size_t kSeconds = 30;
  static constexpr std::int64_t kPeriod = 10;  // frames
  static constexpr std::size_t kMoments = kSeconds * 1000 / static_cast<std::size_t>(kPeriod);

  struct Moment {
    Pose ours;
    std::size_t count = 0;
    std::array<InstanceView, kMaxLinks> others{};
    std::array<bool, kMaxLinks> blocked{};  // something fixed stood between us
  };

  /// `used`: false where no body of the scene is shared; then it keeps nothing.
  explicit PoseHistory(bool used) : moments_(used ? kMoments : 0) {}

  void Forget() noexcept { end_ = begin_ = 0; }
  /// Room for the newest moment.
  Moment& Add() noexcept {
    ++end_;
    if (end_ - begin_ > static_cast<std::int64_t>(moments_.size())) ++begin_;
    return At(end_ - 1);
  }
  bool used() const noexcept { return !moments_.empty(); }
  /// Moments [begin, end) are kept.
  std::int64_t begin() const noexcept { return begin_; }
  std::int64_t end() const noexcept { return end_; }
  const Pose& Ours(std::int64_t moment) const noexcept { return At(moment).ours; }
  /// Null: that one was not heard then.
  const Pose* Of(PeerId peer, std::int64_t moment) const noexcept {
    const Moment& at = At(moment);
    const std::size_t i = PlaceOf(at, peer);
    return i < at.count ? &at.others[i].X_WB : nullptr;
  }
  /// Whether we could have met that one along a straight line then.
  bool WasFree(PeerId peer, std::int64_t moment) const noexcept {
    const Moment& at = At(moment);
    const std::size_t i = PlaceOf(at, peer);
    return i < at.count && !at.blocked[i];
  }

 private:
  static std::size_t PlaceOf(const Moment& at, PeerId peer) noexcept {
    std::size_t i = 0;
    while (i < at.count && at.others[i].peer != peer) ++i;
    return i;
  }
  Moment& At(std::int64_t moment) noexcept {
    return moments_[static_cast<std::size_t>(moment) % moments_.size()];
  }
  const Moment& At(std::int64_t moment) const noexcept {
    return moments_[static_cast<std::size_t>(moment) % moments_.size()];
  }

  std::vector<Moment> moments_;
  std::int64_t begin_ = 0;
  std::int64_t end_ = 0;
};

}  // namespace tandem
