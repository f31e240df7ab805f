#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tandem {

/// The motion of two bodies against one another between two frames; infinite where it is not known.
struct PairMotion {
  double way = 0;    // travel of the frame's origin, voxels
  double angle = 0;  // angle about it, rad
};

/// Keeps items, each due once it may have come a certain way. Under rotation an item moves the
/// farther, the farther out it is. So items are kept in rings by their distance from the origin of
/// the motion, and each ring has its own odometer. There are `kBucketsPerVoxel` buckets per voxel:
/// items are taken up to a bucket early, and never late. Each item has a cost, so that the cost of
/// what is due next is a sum over buckets.
///
///   ring 0   | odometer | + 1 | + 2 | ... | buckets. What is farther than the last is put into any
///   ring 1   | ...                          of the latter half, so that not all are due at once
///
/// Used by one thread. Never allocates after construction.
template <int kBucketsPerVoxel>
class DueCalendar {
 public:
  static constexpr std::size_t kBuckets = 512;
  static constexpr double kPerVoxel = kBucketsPerVoxel;
  /// Voxels ahead that an item can be put in for; items due later are taken by then too.
  static constexpr double kFarthest = (kBuckets - 2) / kPerVoxel;
  /// Outer bounds of the rings, as shares of the radius. Items beyond the last are due earlier.
  static constexpr std::array<double, 8> kRings{0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1, 4};

  /// `radius`: of the body that turns, voxels.
  DueCalendar(std::size_t items, double radius) : radius_(std::max(radius, 1.0)), items_(items) {
    for (Ring& ring : rings_) {
      ring.heads.fill(kNone);
      ring.costs.fill(0);
      ring.filled.fill(0);
    }
  }

  /// Returns the ring of an item that is `out` voxels from the origin and goes at most `ahead`
  /// voxels.
  std::size_t RingOf(double out, double ahead) const noexcept {
    std::size_t r = 0;
    while (r + 1 < kRings.size() && out + ahead > kRings[r] * radius_) ++r;
    return r;
  }
  /// Returns the way that a ring's items may have come so far, voxels, without jumps.
  double odometer(std::size_t ring) const noexcept { return rings_[ring].odometer; }

  /// Puts an item in, or moves it. It is `out` voxels from the origin and due when it has come
  /// `ahead` voxels. `cost`: about what it will cost then.
  void Put(std::uint32_t item, double out, double ahead, std::uint32_t cost) noexcept {
    Remove(item);
    const std::size_t r = RingOf(out, std::min(ahead, kFarthest));
    Ring& ring = rings_[r];
    const double most = kRings.back() * radius_;
    const double scaled = out > most ? ahead * most / out : ahead;
    const double way = scaled > kFarthest ? kFarthest * ShareOfWay(item) : std::max(scaled, 0.0);
    const std::size_t bucket = std::max(BucketAt(ring.odometer + way), ring.now) % kBuckets;
    Item& put = items_[item];
    put = {.next = ring.heads[bucket],
           .before = kNone,
           .cost = cost,
           .slot = static_cast<std::uint16_t>(r * kBuckets + bucket)};
    if (put.next != kNone) items_[put.next].before = item;
    ring.heads[bucket] = item;
    ring.costs[bucket] += cost;
    ++ring.items;
    ring.filled[bucket / 64] |= std::uint64_t{1} << bucket % 64;
  }
  void Remove(std::uint32_t item) noexcept {
    Item& removed = items_[item];
    if (removed.slot == kOut) return;
    Ring& ring = rings_[removed.slot / kBuckets];
    const std::size_t bucket = removed.slot % kBuckets;
    if (removed.before == kNone) {
      ring.heads[bucket] = removed.next;
    } else {
      items_[removed.before].next = removed.next;
    }
    if (removed.next != kNone) items_[removed.next].before = removed.before;
    removed.slot = kOut;
    --ring.items;
    ring.costs[bucket] -= removed.cost;
    if (ring.heads[bucket] == kNone) {
      ring.filled[bucket / 64] &= ~(std::uint64_t{1} << bucket % 64);
    }
  }

  /// Advances by a motion, and by `more` voxels for all items, and takes out what is due. Calls
  /// visit(item), which must neither put in nor remove items.
  template <class Visit>
  void Advance(const PairMotion& motion, double more, const Visit& visit) noexcept {
    for (std::size_t r = 0; r < kRings.size(); ++r) {
      Go(rings_[r], motion.way + motion.angle * kRings[r] * radius_ + more, visit);
    }
  }

  /// Takes out what is due before the body's edge has come `ahead` voxels. Calls visit(item), as
  /// above.
  template <class Visit>
  void TakeWithin(double ahead, const Visit& visit) noexcept {
    for (std::size_t r = 0; r < kRings.size(); ++r) {
      Ring& ring = rings_[r];
      // at most half the calendar: what is put in again is not taken at once
      const double most = std::min(ahead * Farther(r), 0.5 * kFarthest);
      Empty(ring, ring.now, BucketAt(ring.odometer + most), visit);
    }
  }

  /// Sums the costs of the items that are due before the body's edge has come `ahead` buckets with
  /// the motion `like`. The current bucket is included.
  std::uint64_t CostWithin(std::size_t ahead, const PairMotion& like) const noexcept {
    const double edge = like.way + like.angle * radius_;
    const bool moves = edge > 0 && std::isfinite(edge);
    std::uint64_t sum = 0;
    for (std::size_t r = 0; r < kRings.size(); ++r) {
      const Ring& ring = rings_[r];
      const double farther =
          moves ? (like.way + like.angle * kRings[r] * radius_) / edge : Farther(r);
      const double last = std::ceil(static_cast<double>(ahead) * farther);
      const std::size_t most = std::min(static_cast<std::size_t>(last), kBuckets - 1);
      for (std::size_t k = FirstFilled(ring); k <= most; ++k) {
        sum += ring.costs[(ring.now + k) % kBuckets];
      }
    }
    return sum;
  }
  /// Returns the voxels that the body's edge may go before anything is due.
  double FreeTravel() const noexcept {
    double least = kFarthest;
    for (std::size_t r = 0; r < kRings.size(); ++r) {
      const Ring& ring = rings_[r];
      const std::size_t ahead = FirstFilled(ring);
      if (ahead == kBuckets) continue;
      const double way = static_cast<double>(ring.now + ahead) / kPerVoxel - ring.odometer;
      least = std::min(least, std::max(0.0, way) / Farther(r));
    }
    return least;
  }

 private:
  static constexpr std::uint32_t kNone = ~0U;
  static constexpr std::uint16_t kOut = 0xffff;

  /// An item. All of it is read at once, so it stands in one place.
  struct Item {
    std::uint32_t next = 0;
    std::uint32_t before = 0;
    std::uint32_t cost = 0;
    std::uint16_t slot = kOut;  // ring and bucket
  };
  struct Ring {
    double odometer = 0;    // voxels
    std::uint64_t now = 0;  // number of the current bucket
    std::uint32_t items = 0;
    std::array<std::uint32_t, kBuckets> heads;
    std::array<std::uint64_t, kBuckets> costs;
    std::array<std::uint64_t, kBuckets / 64> filled;  // one bit for each bucket with items
  };

  /// Returns the number of the bucket of an odometer's reading. Converts over a signed integer, for
  /// which processors have an instruction.
  static constexpr std::uint64_t BucketAt(double voxels) noexcept {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(voxels * kPerVoxel));
  }
  /// Returns how many buckets ahead the first bucket with items is; kBuckets: there is none.
  static std::size_t FirstFilled(const Ring& ring) noexcept {
    if (ring.items == 0) return kBuckets;
    const std::size_t first = ring.now % kBuckets;
    constexpr std::size_t kWords = kBuckets / 64;
    // the first word is looked at twice, its bits before `first` at the end
    for (std::size_t k = 0; k <= kWords; ++k) {
      const std::size_t word = (first / 64 + k) % kWords;
      std::uint64_t bits = ring.filled[word];
      if (k == 0) bits &= ~std::uint64_t{0} << first % 64;
      if (bits == 0) continue;
      const std::size_t bucket = 64 * word + static_cast<std::size_t>(std::countr_zero(bits));
      return (bucket + kBuckets - first) % kBuckets;
    }
    return kBuckets;
  }

  /// Returns a number from 0.5 to 1, scattered over the items.
  static constexpr double ShareOfWay(std::uint32_t item) noexcept {
    return 0.5 + 0.5 / 65536 * (item * 0x9e3779b1U >> 16U);
  }
  /// Returns how much farther a ring's items may go than the body's edge.
  static constexpr double Farther(std::size_t ring) noexcept { return std::max(1.0, kRings[ring]); }

  template <class Visit>
  void Go(Ring& ring, double voxels, const Visit& visit) noexcept {
    const std::uint64_t first = ring.now;
    if (std::isfinite(voxels)) ring.odometer += voxels;
    ring.now = BucketAt(ring.odometer);
    const bool all = !std::isfinite(voxels) || ring.now - first >= kBuckets;
    const std::uint64_t last = all ? first + kBuckets - 1 : ring.now;
    Empty(ring, first, last, visit);
  }
  /// Takes out the items in the buckets [first, last], numbers of BucketAt().
  template <class Visit>
  void Empty(Ring& ring, std::uint64_t first, std::uint64_t last, const Visit& visit) noexcept {
    if (ring.items == 0) return;
    for (std::uint64_t at = first; at <= last; ++at) Empty(ring, at % kBuckets, visit);
  }
  template <class Visit>
  void Empty(Ring& ring, std::size_t bucket, const Visit& visit) noexcept {
    std::uint32_t item = ring.heads[bucket];
    if (item == kNone) return;
    ring.heads[bucket] = kNone;
    ring.costs[bucket] = 0;
    ring.filled[bucket / 64] &= ~(std::uint64_t{1} << bucket % 64);
    while (item != kNone) {
      const std::uint32_t next = items_[item].next;
      items_[item].slot = kOut;
      --ring.items;
      visit(item);
      item = next;
    }
  }

  double radius_;
  std::array<Ring, kRings.size()> rings_;
  std::vector<Item> items_;
};

}  // namespace tandem
