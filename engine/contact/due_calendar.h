#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tandem {

/// How far two bodies moved against one another between two frames. Without end: nobody knows.
struct PairMotion {
  double way = 0;    // voxels, of the frame's origin
  double angle = 0;  // rad, about it
};

/// Items, each due once it may have come a certain way. What turns goes the farther the farther out
/// it is, so items are kept in rings by their distance from the origin of the motion, each ring
/// with an odometer of its own. In `kBucketsPerVoxel` buckets a voxel, so items are taken up to a
/// bucket early, and never late. Each item has a cost, so what is due next is known as a sum.
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
  /// Voxels ahead that an item can be put in for; it is taken then, however far it is due.
  static constexpr double kFarthest = (kBuckets - 2) / kPerVoxel;
  /// Of the radius: how far out a ring's items may be. Beyond the last they are due the earlier.
  static constexpr std::array<double, 8> kRings{0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1, 4};

  /// `radius` of the body that turns, voxels.
  DueCalendar(std::size_t items, double radius) : radius_(std::max(radius, 1.0)), items_(items) {
    for (Ring& ring : rings_) {
      ring.heads.fill(kNone);
      ring.costs.fill(0);
      ring.filled.fill(0);
    }
  }

  /// The ring of an item that is `out` voxels from the origin and goes `ahead` voxels at the most.
  std::size_t RingOf(double out, double ahead) const noexcept {
    std::size_t r = 0;
    while (r + 1 < kRings.size() && out + ahead > kRings[r] * radius_) ++r;
    return r;
  }
  /// What a ring's items may have come so far, voxels; not over jumps.
  double odometer(std::size_t ring) const noexcept { return rings_[ring].odometer; }

  /// Puts an item in, from wherever it was, that is `out` voxels from the origin and due when it
  /// has come `ahead` voxels; it will cost about so much then.
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

  /// Goes on by a motion, and by so many voxels more for all, and takes out what is due:
  /// visit(item), which neither puts items in nor removes any.
  template <class Visit>
  void Advance(const PairMotion& motion, double more, const Visit& visit) noexcept {
    for (std::size_t r = 0; r < kRings.size(); ++r) {
      Go(rings_[r], motion.way + motion.angle * kRings[r] * radius_ + more, visit);
    }
  }

  /// Takes out what is due before the body's edge has come so many voxels: visit(item), as
  /// above.
  template <class Visit>
  void TakeWithin(double ahead, const Visit& visit) noexcept {
    for (std::size_t r = 0; r < kRings.size(); ++r) {
      Ring& ring = rings_[r];
      // half the calendar at the most: what is put in again is not taken at once
      const double most = std::min(ahead * Farther(r), 0.5 * kFarthest);
      Empty(ring, ring.now, BucketAt(ring.odometer + most), visit);
    }
  }

  /// Sums the costs of the items that are due before the body's edge has come `ahead` buckets,
  /// those of now counted, as it goes on with a motion like that.
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
  /// Voxels that the body's edge may go before anything is due.
  double FreeWay() const noexcept {
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

  /// All of an item is read at once, so it stands in one place.
  struct Item {
    std::uint32_t next = 0;
    std::uint32_t before = 0;
    std::uint32_t cost = 0;
    std::uint16_t slot = kOut;  // ring and bucket
  };
  struct Ring {
    double odometer = 0;    // voxels
    std::uint64_t now = 0;  // its bucket
    std::uint32_t items = 0;
    std::array<std::uint32_t, kBuckets> heads;
    std::array<std::uint64_t, kBuckets> costs;
    std::array<std::uint64_t, kBuckets / 64> filled;  // a bit for each bucket with items
  };

  /// The number of the bucket of an odometer's reading. Over a signed number, which processors
  /// convert to at once.
  static constexpr std::uint64_t BucketAt(double voxels) noexcept {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(voxels * kPerVoxel));
  }
  /// How many buckets ahead the first one with items is; kBuckets: there is none.
  static std::size_t FirstFilled(const Ring& ring) noexcept {
    if (ring.items == 0) return kBuckets;
    const std::size_t first = ring.now % kBuckets;
    constexpr std::size_t kWords = kBuckets / 64;
    // the word of now is looked at twice, its bits before now at the end
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

  /// From a half to 1, scattered.
  static constexpr double ShareOfWay(std::uint32_t item) noexcept {
    return 0.5 + 0.5 / 65536 * (item * 0x9e3779b1U >> 16U);
  }
  /// How much farther a ring's items may go than the body's edge.
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
  /// Takes out what is in the buckets [first, last], numbers of BucketAt().
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
