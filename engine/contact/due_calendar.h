#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tandem {

/// Items, each due once an odometer has reached what it is put in for. In buckets of an eighth of
/// a voxel, so items are taken up to so much early, and never late.
///
///   bucket   | odometer | + 1/8 | + 2/8 | ... |    a ring; the last holds all that is farther
///
/// Used by one thread. Never allocates after construction.
class DueCalendar {
 public:
  static constexpr std::size_t kBuckets = 512;
  static constexpr double kPerVoxel = 8;
  /// Voxels ahead that an item can be put in for; it is taken then, however far it is due.
  static constexpr double kFarthest = (kBuckets - 2) / kPerVoxel;

  explicit DueCalendar(std::size_t items) : next_(items, kNone), before_(items), bucket_(items) {
    bucket_.assign(items, kOut);
    heads_.fill(kNone);
    counts_.fill(0);
  }

  double odometer() const noexcept { return odometer_; }
  /// Puts an item in, from wherever it was.
  void Put(std::uint32_t item, double due) noexcept {
    Remove(item);
    const double ahead = std::clamp(due - odometer_, 0.0, kFarthest);
    const auto at = static_cast<std::uint64_t>((odometer_ + ahead) * kPerVoxel);
    const auto bucket = static_cast<std::uint16_t>(std::max(at, now_) % kBuckets);
    bucket_[item] = bucket;
    before_[item] = kNone;
    next_[item] = heads_[bucket];
    if (next_[item] != kNone) before_[next_[item]] = item;
    heads_[bucket] = item;
    ++counts_[bucket];
  }
  void Remove(std::uint32_t item) noexcept {
    const std::uint16_t bucket = bucket_[item];
    if (bucket == kOut) return;
    if (before_[item] == kNone) {
      heads_[bucket] = next_[item];
    } else {
      next_[before_[item]] = next_[item];
    }
    if (next_[item] != kNone) before_[next_[item]] = before_[item];
    bucket_[item] = kOut;
    --counts_[bucket];
  }

  /// Goes on by so many voxels, which may be without end, and takes out what is due: visit(item).
  template <class Visit>
  void Advance(double voxels, const Visit& visit) noexcept {
    const std::uint64_t first = now_;
    if (std::isfinite(voxels)) odometer_ += voxels;
    now_ = static_cast<std::uint64_t>(odometer_ * kPerVoxel);
    const bool all = !std::isfinite(voxels) || now_ - first >= kBuckets;
    const std::uint64_t last = all ? first + kBuckets - 1 : now_;
    for (std::uint64_t at = first; at <= last; ++at) {
      const std::size_t bucket = at % kBuckets;
      std::uint32_t item = heads_[bucket];
      heads_[bucket] = kNone;
      counts_[bucket] = 0;
      while (item != kNone) {
        const std::uint32_t next = next_[item];
        bucket_[item] = kOut;
        visit(item);
        item = next;
      }
    }
  }

  /// How many items are due within `ahead` buckets of now, those of now counted.
  std::uint32_t DueWithin(std::size_t ahead) const noexcept {
    std::uint32_t sum = 0;
    for (std::size_t k = 0; k <= std::min(ahead, kBuckets - 1); ++k) {
      sum += counts_[(now_ + k) % kBuckets];
    }
    return sum;
  }
  /// Voxels that may be gone before anything is due.
  double FreeWay() const noexcept {
    for (std::size_t k = 0; k < kBuckets; ++k) {
      if (counts_[(now_ + k) % kBuckets] != 0) {
        return std::max(0.0, static_cast<double>(now_ + k) / kPerVoxel - odometer_);
      }
    }
    return kFarthest;
  }

 private:
  static constexpr std::uint32_t kNone = ~0U;
  static constexpr std::uint16_t kOut = 0xffff;

  double odometer_ = 0;    // voxels
  std::uint64_t now_ = 0;  // its bucket
  std::array<std::uint32_t, kBuckets> heads_{};
  std::array<std::uint32_t, kBuckets> counts_{};
  std::vector<std::uint32_t> next_;
  std::vector<std::uint32_t> before_;
  std::vector<std::uint16_t> bucket_;
};

}  // namespace tandem
