#include "engine/contact/features/edge_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "engine/contact/features/edge_contact.h"

namespace tandem {

namespace {

/// The number of pairs of parts that are compared in the time of a look-up: most by their middles
/// only.
constexpr std::size_t kPairsOfALookUp = 4;

/// Returns the least distance of two pieces of lines. The middle of the first is `between` from the
/// other's. Each has a vector from its middle to an end.
double PiecesApart(const Vec3& between, const Vec3& half, const Vec3& other_half) noexcept {
  const double a = half.squaredNorm();
  const double b = half.dot(other_half);
  const double c = other_half.squaredNorm();
  const double d = half.dot(between);
  const double e = other_half.dot(between);
  const double square = a * c - b * b;
  const auto on_piece = [](double share) {
    return std::clamp(share, -1.0, 1.0);
  };
  const double on_line = square > 1e-9 * a * c ? on_piece((b * e - c * d) / square) : 0.0;
  const double v = on_piece((b * on_line + e) / c);
  const double u = on_piece((b * v - d) / a);
  return (between + u * half - v * other_half).norm();
}

/// Keeps edge parts of the other body that may be near some of a block's.
class OthersNear {
 public:
  static constexpr std::size_t kRoom = 128;

  /// Stores places relative to `origin_V`.
  explicit OthersNear(const Vec3& origin_V) noexcept : origin_V_(origin_V) {}

  std::size_t count() const noexcept { return count_; }
  bool full() const noexcept { return count_ == kRoom; }
  void Add(const BodyFeatures::Edge& edge) noexcept {
    const Vec3 from_origin = edge.middle - origin_V_;
    edges_[count_] = &edge;
    x_[count_] = static_cast<float>(from_origin.x());
    y_[count_] = static_cast<float>(from_origin.y());
    z_[count_] = static_cast<float>(from_origin.z());
    half_length_[count_] = edge.half_length;
    ++count_;
  }
  void Clear() noexcept { count_ = 0; }

  /// Returns a part's gap to these parts, which push from `reach` on; `least` if that is less.
  double GapOf(const EdgePart& part, double reach, double least) const noexcept {
    // few are near: single precision finds the near middles, several at once
    const Vec3 place = part.middle_V - origin_V_;
    const auto x = static_cast<float>(place.x());
    const auto y = static_cast<float>(place.y());
    const auto z = static_cast<float>(place.z());
    const auto most = static_cast<float>(reach + part.half_length + least + kPlaceError);
    std::array<std::uint8_t, kRoom> is_near;
    for (std::size_t i = 0; i < count_; ++i) {
      const float dx = x_[i] - x;
      const float dy = y_[i] - y;
      const float dz = z_[i] - z;
      const float apart = most + half_length_[i];
      is_near[i] = dx * dx + dy * dy + dz * dz < apart * apart ? 1 : 0;
    }
    for (std::size_t i = 0; i < count_; ++i) {
      if (is_near[i] != 0) least = std::min(least, PairGap(part, *edges_[i], reach));
    }
    return least;
  }

 private:
  static double PairGap(const EdgePart& part, const BodyFeatures::Edge& other,
                        double reach) noexcept {
    const Vec3 between = part.middle_V - other.middle;
    if (!part.outside) return between.norm() - part.half_length - other.half_length - reach;
    // nearly parallel pieces push only where the part's middle is near the surface, all others only
    // where they are near one another (MeetEdges())
    const double pieces_apart =
        PiecesApart(between, (part.half_length + kSeam) * part.tangent_V,
                    (other.half_length + kSeam) * other.tangent.cast<double>());
    return std::min(part.middle_bound, pieces_apart) - reach;
  }

  Vec3 origin_V_;
  std::size_t count_ = 0;
  std::array<const BodyFeatures::Edge*, kRoom> edges_;
  std::array<float, kRoom> x_;
  std::array<float, kRoom> y_;
  std::array<float, kRoom> z_;
  std::array<float, kRoom> half_length_;
};

}  // namespace

std::size_t QueryAlong(const DistanceField& field, double reach,
                       std::span<EdgePart> parts) noexcept {
  // places besides the middle, whose distance is known: no place of a part is farther from the
  // nearest of these than a quarter of its half length, or than its seam
  constexpr std::array<double, 4> kAlong{-1.0, -0.5, 0.5, 1.0};
  constexpr std::size_t kMost = kAlong.size() * kBlockPlaces;
  const auto slack = [](const EdgePart& part) {
    return std::max(0.25 * part.half_length, kSeam) + kPlaceError;
  };
  std::array<EdgePart*, kBlockPlaces> queried;
  std::array<float, kMost> x{};
  std::array<float, kMost> y{};
  std::array<float, kMost> z{};
  std::array<float, kMost> values;
  std::array<std::int32_t, kMost> kinds;
  std::array<float, kMost> over;
  std::size_t queried_count = 0;
  std::size_t count = 0;
  for (EdgePart& part : parts) {
    // the middle alone excludes contact
    if (part.middle_bound - slack(part) <= reach) continue;
    queried[queried_count++] = &part;
    for (const double along : kAlong) {
      const Vec3 place = part.middle_V + along * part.half_length * part.tangent_V;
      x[count] = static_cast<float>(place.x());
      y[count] = static_cast<float>(place.y());
      z[count] = static_cast<float>(place.z());
      ++count;
    }
  }
  if (count == 0) return 0;
  field.Values({0, 0, 0}, {x.data(), y.data(), z.data()}, (count + 15) / 16 * 16, values.data(),
               kinds.data(), over.data());
  for (std::size_t i = 0; i < queried_count; ++i) {
    EdgePart& part = *queried[i];
    double least = part.middle_bound;
    for (std::size_t k = kAlong.size() * i; k < kAlong.size() * (i + 1); ++k) {
      least = std::min<double>(least, values[k] - over[k]);
    }
    least -= slack(part);
    part.gap = std::max(part.gap, least - reach);
    part.outside = least > 0;
  }
  return count;
}

std::size_t QueryOtherEdges(const BodyFeatures& others, double reach, double enough,
                            std::span<EdgePart> parts) noexcept {
  std::array<EdgePart*, kBlockPlaces> queried;
  std::array<double, kBlockPlaces> gaps;
  gaps.fill(kEdgesEnough);
  std::size_t count = 0;
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  double longest = 0;
  for (EdgePart& part : parts) {
    if (part.gap > enough) continue;
    queried[count++] = &part;
    low = low.cwiseMin(part.middle_V);
    high = high.cwiseMax(part.middle_V);
    longest = std::max(longest, part.half_length);
  }
  if (count == 0) return 0;
  const double most = reach + longest + kEdgesEnough + kPlaceError;
  const Vec3 margin = Vec3::Constant(most + others.longest_half());
  OthersNear near(low);
  std::size_t pairs = 0;
  const auto look = [&] {
    pairs += count * near.count();
    for (std::size_t i = 0; i < count; ++i) gaps[i] = near.GapOf(*queried[i], reach, gaps[i]);
    near.Clear();
  };
  others.VisitEdgesIn(low - margin, high + margin, [&](const BodyFeatures::Edge& edge) {
    const double apart = most + edge.half_length;
    const Vec3 beyond = (low - edge.middle).cwiseMax(edge.middle - high);
    if (beyond.maxCoeff() > apart) return;
    near.Add(edge);
    if (near.full()) look();
  });
  look();
  for (std::size_t i = 0; i < count; ++i) queried[i]->gap = std::max(queried[i]->gap, gaps[i]);
  return pairs / kPairsOfALookUp;
}

}  // namespace tandem
