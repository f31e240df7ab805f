#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "engine/field/distance_field.h"
#include "engine/geometry/closest_on_triangle.h"

namespace tandem {

namespace {

/// Voxels: nearer to a face than this, its normal tells the way.
constexpr double kTouching = 1e-4;
/// Of a second face, voxels above the first one's plane from which on it pushes in full.
constexpr double kApart = 0.1;
/// The share of a push that is none.
constexpr double kNothing = 1e-4;

}  // namespace

/// The faces of a cell's list near a place, the nearest first.
struct DistanceField::FacesNear {
  struct Face {
    double distance;  // never negative
    Vec3 closest;
    Vec3 away;      // unit, from the face
    double height;  // of the place above the face's plane
    bool sheet;
  };
  static constexpr std::size_t kMost = 16;
  std::size_t count = 0;
  std::array<Face, kMost> faces;

  void Add(const Face& face) {
    if (count == kMost && face.distance >= faces[count - 1].distance) return;
    std::size_t at = count < kMost ? count++ : count - 1;
    for (; at > 0 && face.distance < faces[at - 1].distance; --at) faces[at] = faces[at - 1];
    faces[at] = face;
  }
  /// The nearest face; of equally near ones the one that turns most to the place.
  const Face& Told() const {
    const Face* told = &faces[0];
    for (std::size_t i = 1; i < count && faces[i].distance < faces[0].distance + kTie; ++i) {
      if (std::abs(faces[i].height) > std::abs(told->height)) told = &faces[i];
    }
    return *told;
  }
  /// Tells whether the place is in the solid.
  bool Inside() const { return !Told().sheet && Told().height < 0; }
};

namespace {

/// How much of a push by `face` counts beside that by `first`, which is nearer. Nothing of what
/// lies in the first one's plane or falls off from it; all of what stands up from it, or is as
/// near.
double ShareBeside(const auto& face, const auto& first) {
  const double up = first.away.dot(face.closest - first.closest);
  if (up <= 0) return 0;
  const double as_near = 1.0 - (face.distance - first.distance) / up;
  return std::clamp(std::max(as_near, up / kApart), 0.0, 1.0);
}

}  // namespace

DistanceField::FacesNear DistanceField::FacesWithin(const List& list, const Vec3& place_L,
                                                    double reach) const {
  constexpr std::size_t kMost = 64;
  std::array<std::uint32_t, kMost> entries;
  std::array<Vec3, kMost> closest;
  std::array<double, kMost> squares;
  std::size_t count = 0;
  double least = std::numeric_limits<double>::infinity();
  FacesNear near;
  const auto keep = [&](std::size_t k) {
    const Face& face = faces_[entries[k] & ~kSheet];
    const Vec3 a = face[0].cast<double>();
    const Vec3 nhat = (face[1].cast<double>() - a).cross(face[2].cast<double>() - a).normalized();
    const Vec3 from = place_L - closest[k];
    const double distance = std::sqrt(squares[k]);
    const double height = nhat.dot(from);
    const bool sheet = (entries[k] & kSheet) != 0;
    const Vec3 on_face = sheet && height < 0 ? Vec3(-nhat) : nhat;
    const Vec3 away = distance > kTouching ? Vec3(from / distance) : on_face;
    near.Add({distance, closest[k], away, height, sheet});
  };
  for (std::size_t byte = 0; byte < list.member_bytes; ++byte) {
    for (std::uint32_t bits = list.members[byte]; bits != 0; bits &= bits - 1) {
      if (count == kMost) continue;
      entries[count] = list.faces[8 * byte + static_cast<std::size_t>(std::countr_zero(bits))];
      const Face& face = faces_[entries[count] & ~kSheet];
      closest[count] = ClosestOnTriangle(face[0].cast<double>(), face[1].cast<double>(),
                                         face[2].cast<double>(), place_L)
                           .point;
      squares[count] = (place_L - closest[count]).squaredNorm();
      least = std::min(least, squares[count]);
      ++count;
    }
  }
  // all as near as the nearest tell the side together
  const double most = std::max(std::sqrt(least) + kTie, reach);
  for (std::size_t k = 0; k < count; ++k) {
    if (squares[k] <= most * most) keep(k);
  }
  return near;
}

FieldGradient DistanceField::OfList(const List& list, const Vec3& place_L) const {
  const FacesNear near = FacesWithin(list, place_L, 0);
  const bool inside = near.Inside();
  const FacesNear::Face& told = near.Told();
  const double nearest = near.faces[0].distance;
  // on the face itself its normal tells, which points out already
  const bool turned = inside && told.distance > kTouching;
  return {.reading = {.value = inside ? -nearest : nearest, .near = true},
          .gradient = turned ? Vec3(-told.away) : told.away};
}

std::size_t DistanceField::Pushes(const Vec3& place_V, double reach,
                                  std::array<FieldPush, kMostPushes>& pushes) const noexcept {
  const Vec3 place_L = place_V - Vec3::Constant(0.5);
  const Vec3 size_L = kHyperbrickCells * Vec3(size_.x, size_.y, size_.z);
  if (!((place_L.array() >= 0).all() && (place_L.array() < size_L.array()).all())) return 0;
  const Cell cell = CellOf(place_L);
  const std::int32_t entry = EntryOf(cell.cell);
  if (entry < 0) return 0;
  const FieldBrick& brick = bricks_[static_cast<std::size_t>(entry)];
  const std::optional<List> list = ListOf(brick, cell.cell);
  double share = 0;  // of the list
  if (list) {
    std::array<double, 8> shares;
    for (std::size_t i = 0; i < 8; ++i) shares[i] = list->shares >> i & 1;
    share = InCube(shares, cell.from);
  }
  const FacesNear near = share > 0 ? FacesWithin(*list, place_L, reach) : FacesNear{};
  if (share > 0) {
    // beyond the band other faces may be nearer than those of the list
    share *= std::clamp((band_ - near.faces[0].distance) / kBandFade, 0.0, 1.0);
  }
  std::size_t count = 0;
  if (share < 1) {
    double value = Interpolated(brick, cell);
    if (value > fine_band() && reach > fine_band()) value = AtLeast(value, OverAt(cell));
    if (value < reach) {
      const Vec3 gradient = GradientAt(brick, cell, place_L);
      const double length = gradient.norm();
      if (length > 0) pushes[count++] = {value, gradient / length, 1.0 - share, false, 1};
    }
  }
  if (share == 0) return count;
  if (near.Inside()) {
    const auto& face = near.faces[0];
    // on the face itself its normal tells, which points out already
    const Vec3 away = face.distance > kTouching ? Vec3(-face.away) : face.away;
    pushes[count++] = {-face.distance, away, share, false, 1};
    return count;
  }
  // those that push, the nearest first: what counts little takes little from those behind it
  std::array<std::size_t, kMostPushes> kept;
  std::array<double, kMostPushes> kept_counts;
  std::size_t kept_count = 0;
  for (std::size_t i = 0; i < near.count && count < kMostPushes; ++i) {
    const auto& face = near.faces[i];
    if (face.distance >= reach) break;
    double counts = 1;
    for (std::size_t k = 0; k < kept_count; ++k) {
      const double beside = ShareBeside(face, near.faces[kept[k]]);
      counts = std::min(counts, 1.0 - kept_counts[k] * (1.0 - beside));
    }
    if (counts < kNothing) continue;
    kept[kept_count] = i;
    kept_counts[kept_count++] = counts;
    const double facing = face.distance > kTouching ? std::abs(face.height) / face.distance : 1.0;
    pushes[count++] = {face.distance, face.away, share * counts, face.sheet, facing};
  }
  return count;
}

}  // namespace tandem
