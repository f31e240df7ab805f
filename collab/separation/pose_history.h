#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "collab/coupling/link_views.h"

namespace tandem {

/// Keeps the poses of the instances of a shared body over the last kSeconds: our own, and the
/// others' as heard. Moments are counted from 0 and are kPeriod frames apart. Nothing allocates
/// after construction.
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

  /// `used`: false where no body of the scene is shared; then nothing is kept.
  explicit PoseHistory(bool used) : moments_(used ? kMoments : 0) {}

  void Forget() noexcept { end_ = begin_ = 0; }
  /// Makes room for the newest moment.
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
  /// The pose of a peer's instance at a moment; null: it was not heard then.
  const Pose* PoseOf(PeerId peer, std::int64_t moment) const noexcept {
    const Moment& at = At(moment);
    const std::size_t i = IndexOf(at, peer);
    return i < at.count ? &at.others[i].X_WB : nullptr;
  }
  /// Returns whether a straight line to that peer's instance was free then.
  bool WasFree(PeerId peer, std::int64_t moment) const noexcept {
    const Moment& at = At(moment);
    const std::size_t i = IndexOf(at, peer);
    return i < at.count && !at.blocked[i];
  }

 private:
  static std::size_t IndexOf(const Moment& at, PeerId peer) noexcept {
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
