#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engine/field/query/distance_field.h"
#include "engine/field/query/list_pairs.h"

namespace tandem {

namespace {

/// Distance from a face below which its normal gives the direction, voxels.
constexpr double kTouching = 1e-4;
constexpr double kTie = ListPairs::kTie;
/// Height above the first face's plane from which on a second face pushes in full, voxels.
constexpr double kApart = 0.1;
/// Voxels that single precision may lift a face over another's plane in which it lies. Over as much
/// again its push grows to its full share.
constexpr double kLifted = 2e-5;
/// The greatest share of a push that counts as none.
constexpr double kNothing = 1e-4;

/// A face near a place.
struct NearbyFace {
  double distance;  // never negative
  Vec3 to;          // from the place to the closest point
  Vec3 away;        // unit, from the face
  double height;    // height of the place above the face's plane
  bool sheet;
};

/// Returns the unit normal of a pair's face.
Vec3 NormalOf(const ListPairs& pairs, std::size_t k) {
  const auto corner = [&](std::size_t number) {
    const float* words = &pairs.corners[number][4 * k + (number == 2 ? 1 : 0)];
    return Vec3(words[0], words[1], words[2]);
  };
  const Vec3 a = corner(0);
  return (corner(1) - a).cross(corner(2) - a).normalized();
}

/// The faces of a cell's list near a place, the nearest first.
class FacesNear {
 public:
  /// Takes from measured pairs the nearest face, and all that are nearer than `reach`.
  FacesNear(const ListPairs& pairs, std::size_t begin, std::size_t end, double reach) {
    faces_[0] = {0, Vec3::Zero(), Vec3::Zero(), 0, false};
    float least = std::numeric_limits<float>::infinity();
    for (std::size_t k = begin; k < end; ++k) least = std::min(least, pairs.squared[k]);
    // all faces as near as the nearest give the side together
    const double most = std::max(std::sqrt(double{least}) + kTie, reach);
    for (std::size_t k = begin; k < end; ++k) {
      if (pairs.squared[k] <= most * most) Add(FaceOf(pairs, k));
    }
  }
  std::span<const NearbyFace> all() const { return std::span(faces_).first(count_); }
  /// Returns the nearest face; among equally near faces the face that turns most to the place.
  const NearbyFace& Nearest() const {
    const NearbyFace* nearest = faces_.data();
    for (const NearbyFace& face : all()) {
      if (face.distance >= faces_[0].distance + kTie) break;
      if (std::abs(face.height) > std::abs(nearest->height)) nearest = &face;
    }
    return *nearest;
  }
  /// Tells whether the place is in the solid.
  bool Inside() const { return !Nearest().sheet && Nearest().height < 0; }

 private:
  static NearbyFace FaceOf(const ListPairs& pairs, std::size_t k) {
    NearbyFace face{std::sqrt(double{pairs.squared[k]}),
                    Vec3(pairs.to_face[0][k], pairs.to_face[1][k], pairs.to_face[2][k]),
                    {},
                    pairs.height[k],
                    pairs.sheet[k]};
    if (face.distance > kTouching) {
      face.away = face.to / -face.distance;
    } else {
      face.away = NormalOf(pairs, k);
      if (face.sheet && face.height < 0) face.away = -face.away;
    }
    return face;
  }
  void Add(const NearbyFace& face) {
    if (count_ == faces_.size() && face.distance >= faces_.back().distance) return;
    std::size_t at = count_ < faces_.size() ? count_++ : count_ - 1;
    for (; at > 0 && face.distance < faces_[at - 1].distance; --at) faces_[at] = faces_[at - 1];
    faces_[at] = face;
  }

  std::size_t count_ = 0;
  std::array<NearbyFace, 16> faces_;
};

/// Returns the share of a push by `face` beside a push by `first`, which is nearer. It is nothing
/// for a face that lies in the first one's plane or falls off from it, and 1 for a face that stands
/// up from it, or is as near.
double ShareBeside(const NearbyFace& face, const NearbyFace& first) {
  const double up = first.away.dot(face.to - first.to);
  if (up <= kLifted) return 0;
  const double as_near = 1.0 - (face.distance - first.distance) / up;
  const double stands_up = std::min(1.0, (up - kLifted) / kLifted);
  return std::clamp(std::max(stands_up * as_near, up / kApart), 0.0, 1.0);
}

/// Returns how much the pushes of two faces are one and the same: all of it along one way, nothing
/// from 45 degrees between them on.
double Alike(const NearbyFace& one, const NearbyFace& other) {
  constexpr double kOfTheirOwn = 1.0 - 0.70710678118654752;
  return std::clamp(1.0 - (1.0 - one.away.dot(other.away)) / kOfTheirOwn, 0.0, 1.0);
}

/// Returns the gradient that faces give a place, as DistanceField::At() does.
FieldGradient GradientOf(const FacesNear& near) {
  const bool inside = near.Inside();
  const NearbyFace& face = near.Nearest();
  const double nearest = near.all()[0].distance;
  // on the face itself its normal gives the direction, which points out already
  const bool turned = inside && face.distance > kTouching;
  return {.reading = {.value = inside ? -nearest : nearest, .near = true},
          .gradient = turned ? Vec3(-face.away) : face.away};
}

}  // namespace

/// Places in lanes, with their interpolated values. Gathers as many places as fit whose lists
/// count.
class DistanceField::PushLanes {
 public:
  /// A place, and its pairs if its list counts.
  struct ListedPlace {
    std::size_t begin = 0, end = 0;  // range of the pairs; empty: no list counts
    double share = 0;                // share of the list
  };

  PushLanes(const DistanceField& field, std::span<const Vec3> places_V)
      : field_(field), count_(places_V.size()) {
    field.InterpolateGradients(field.SetLanes(places_V, lanes_), lanes_, gradients_);
  }
  const FieldLanes& lanes() const { return lanes_; }
  bool HasBrick(std::size_t k) const { return lanes_.entry[k] >= 0; }
  Vec3 gradient(std::size_t k) const {
    return {gradients_[0][k], gradients_[1][k], gradients_[2][k]};
  }
  const ListPairs& pairs() const { return pairs_; }
  /// Calls visit(lane, list's place) for all places, in order.
  template <class Visit>
  void ForEach(const Visit& visit) {
    for (std::size_t begin = 0; begin < count_;) {
      const std::size_t end = Gather(begin);
      MeasureWays(pairs_);
      for (std::size_t k = begin; k < end; ++k) visit(k, listed_[k - begin]);
      begin = end;
    }
  }

 private:
  /// Gathers as many places from `begin` on as there is room for their faces, at least one. Returns
  /// the end.
  std::size_t Gather(std::size_t begin) {
    pairs_.count = 0;
    std::size_t k = begin;
    for (; k < count_; ++k) {
      ListedPlace& place = listed_[k - begin] = {};
      if (!HasBrick(k)) continue;
      const std::optional<List> list = field_.ListOf(lanes_, k);
      if (!list) continue;
      if (k > begin && !pairs_.HasRoomFor(8 * list->member_bytes)) break;
      place.share = ShareOf(*list, Vec3(lanes_.x[k], lanes_.y[k], lanes_.z[k]));
      if (place.share == 0) continue;
      place.begin = pairs_.count;
      field_.AddPairs(*list, lanes_.CellOf(k), lanes_.FromCell(k), pairs_);
      place.end = pairs_.count;
    }
    return k;
  }

  const DistanceField& field_;
  std::size_t count_;
  FieldLanes lanes_;
  FieldGradients gradients_;
  ListPairs pairs_;
  std::array<ListedPlace, FieldPushes::kMostPlaces> listed_;
};

std::size_t DistanceField::SetLanes(std::span<const Vec3> places_V,
                                    FieldLanes& lanes) const noexcept {
  const Vec3 size_L = kHyperbrickCells * Vec3(size_.x, size_.y, size_.z);
  const std::size_t padded =
      (places_V.size() + FieldLanes::kVector - 1) / FieldLanes::kVector * FieldLanes::kVector;
  for (std::size_t k = 0; k < padded; ++k) {
    const Vec3 place_L = places_V[std::min(k, places_V.size() - 1)] - Vec3::Constant(0.5);
    // written so that NaN lies outside too
    const bool inside = (place_L.array() >= 0).all() && (place_L.array() < size_L.array()).all();
    const Cell cell = inside ? CellOf(place_L) : Cell{{-1, -1, -1}, Vec3::Zero()};
    lanes.cell_x[k] = cell.cell.x;
    lanes.cell_y[k] = cell.cell.y;
    lanes.cell_z[k] = cell.cell.z;
    lanes.x[k] = static_cast<float>(cell.from.x());
    lanes.y[k] = static_cast<float>(cell.from.y());
    lanes.z[k] = static_cast<float>(cell.from.z());
  }
  return padded;
}

void DistanceField::WithGradients(std::span<const Vec3> places_V,
                                  FieldGradient* gradients) const noexcept {
  for (std::size_t begin = 0; begin < places_V.size(); begin += FieldPushes::kMostPlaces) {
    const auto some =
        places_V.subspan(begin, std::min(FieldPushes::kMostPlaces, places_V.size() - begin));
    PushLanes places(*this, some);
    places.ForEach([&](std::size_t k, const PushLanes::ListedPlace& listed) {
      FieldGradient& gradient = gradients[begin + k];
      const double value = places.HasBrick(k) ? places.lanes().value[k] : 0;
      if (!places.HasBrick(k) ||
          (listed.end == listed.begin && (value > most_near_ || value < -kMostNear))) {
        gradient = {.reading = At(some[k])};
        return;
      }
      gradient = {.reading = {.value = value, .near = true}, .gradient = places.gradient(k)};
      if (listed.end == listed.begin) return;
      const FieldGradient exact =
          GradientOf(FacesNear(places.pairs(), listed.begin, listed.end, 0));
      gradient.reading.value += listed.share * (exact.reading.value - value);
      gradient.gradient += listed.share * (exact.gradient - gradient.gradient);
    });
  }
}

namespace {

/// Returns FieldPush::facing. Where an edge or a corner is nearest, its faces are equally near, and
/// the face that turns most to the place counts.
double FacingOf(const NearbyFace& face, const FacesNear& near) {
  if (face.distance <= kTouching) return 1;
  double height = 0;
  for (const NearbyFace& other : near.all()) {
    if (other.distance > face.distance + kTie) break;
    if ((other.to - face.to).squaredNorm() > kTie * kTie) continue;
    height = std::max(height, std::abs(other.height));
  }
  return height / face.distance;
}

/// Adds the pushes of a list's faces, the nearest first. A push that counts little takes little
/// from the pushes after it. Pushes that are alike share their weight, as far as each is deep, so
/// that facets of a hollow push together as one.
void AddPushes(const FacesNear& near, double share, double reach, FieldPush*& next,
               const FieldPush* end) {
  if (near.Inside()) {
    const NearbyFace& face = near.all()[0];
    if (-face.distance >= reach) return;  // force may begin in the solid
    // on the face itself its normal gives the direction, which points out already
    const Vec3 away = face.distance > kTouching ? Vec3(-face.away) : face.away;
    *next++ = {-face.distance, away, share, false, 1};
    return;
  }
  std::array<const NearbyFace*, FieldPushes::kMostEach> kept;
  std::array<double, FieldPushes::kMostEach> counts;
  std::size_t count = 0;
  const std::size_t room = std::min(kept.size(), static_cast<std::size_t>(end - next));
  for (const NearbyFace& face : near.all()) {
    if (face.distance >= reach || count == room) break;
    double own = 1;
    for (std::size_t k = 0; k < count; ++k) {
      own = std::min(own, 1.0 - counts[k] * (1.0 - ShareBeside(face, *kept[k])));
    }
    if (own < kNothing) continue;
    kept[count] = &face;
    counts[count++] = own;
  }
  for (std::size_t i = 0; i < count; ++i) {
    double most = 0;
    double beside = 0;
    for (std::size_t k = 0; k < count; ++k) {
      if (k == i) continue;
      // a face whose push begins at the reach takes as little as it pushes
      const double depth = (reach - kept[k]->distance) / (reach - kept[i]->distance);
      const double taken = counts[k] * Alike(*kept[i], *kept[k]) * std::min(1.0, depth);
      most = std::max(most, taken);
      beside += taken;
    }
    const double all = counts[i] + (1.0 - counts[i]) * (1.0 - most) + beside;
    const NearbyFace& face = *kept[i];
    *next++ = {face.distance, face.away, share * counts[i] / all, face.sheet, FacingOf(face, near)};
  }
}

/// Replaces an interpolated push and the first push of a list, which fade into one another, by
/// their sum. Between an edge's faces the interpolated direction alone may be far off. As the depth
/// of one vanishes, the sum becomes the other. The list's other pushes move up by one. A sheet's
/// push stays separate, because FieldPair may turn it round. Returns the new end.
FieldPush* Merge(double reach, FieldPush* interpolated, FieldPush* next) {
  FieldPush& first = interpolated[0];
  const FieldPush& listed = interpolated[1];
  const double of_first = first.share * (reach - first.distance);
  const double of_listed = listed.share * (reach - listed.distance);
  const Vec3 sum = of_first * first.away_V + of_listed * listed.away_V;
  const double length = sum.norm();
  if (listed.sheet || !(length > 0)) return next;
  const auto mean = [&](double one, double other) {
    return (of_first * one + of_listed * other) / (of_first + of_listed);
  };
  const double distance = mean(first.distance, listed.distance);
  first = {distance, sum / length, length / (reach - distance), false,
           mean(first.facing, listed.facing)};
  return std::move(interpolated + 2, next, interpolated + 1);
}

}  // namespace

void DistanceField::Pushes(std::span<const Vec3> places_V, double reach,
                           FieldPushes& pushes) const noexcept {
  FieldPush* next = pushes.all.data();
  if (places_V.empty()) return;
  PushLanes places(*this, places_V);
  places.ForEach([&](std::size_t k, const PushLanes::ListedPlace& listed) {
    pushes.first[k] = static_cast<std::uint16_t>(next - pushes.all.data());
    const FieldPush* end = next + FieldPushes::kMostEach;
    if (places.HasBrick(k)) {
      double share = 0;  // share of the list
      std::optional<FacesNear> near;
      if (listed.end > listed.begin) {
        near.emplace(places.pairs(), listed.begin, listed.end, reach);
        // beyond the band other faces may be nearer than those of the list
        share = listed.share * std::clamp((band_ - near->all()[0].distance) / kBandFade, 0.0, 1.0);
      }
      double value = places.lanes().value[k];
      if (share < 1 && value > fine_band() && reach > fine_band()) {
        const FieldLanes& lanes = places.lanes();
        value = AtLeast(value, OverAt({lanes.CellOf(k), {lanes.x[k], lanes.y[k], lanes.z[k]}}));
      }
      FieldPush* interpolated = nullptr;
      if (share < 1 && value < reach) {
        const Vec3 gradient = places.gradient(k);
        const double length = gradient.norm();
        if (length > 0) {
          interpolated = next;
          *next++ = {value, gradient / length, 1.0 - share, false, 1};
        }
      }
      if (share > 0) AddPushes(*near, share, reach, next, end);
      if (interpolated != nullptr && next - interpolated > 1) {
        next = Merge(reach, interpolated, next);
      }
    }
    pushes.first[k + 1] = static_cast<std::uint16_t>(next - pushes.all.data());
  });
}

}  // namespace tandem
