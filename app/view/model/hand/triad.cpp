#include "app/view/model/hand/triad.h"

#include <cmath>
#include <numbers>

namespace tandem {

namespace {

constexpr double kReachPx = 7;           // distance from a handle's line
constexpr double kShortestArrowPx = 14;  // a shorter arrow is nearly a dot and unusable
constexpr double kFlattest = 0.15;       // sine of the angle at which a square is seen

double DistanceToSegment(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 ab = b - a;
  const double length2 = ab.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(ab) / length2, 0.0, 1.0) : 0.0;
  return (p - (a + t * ab)).norm();
}

bool Inside(const std::array<Vec2, 4>& corners, const Vec2& p) {
  int left = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec2 along = corners[(i + 1) % 4] - corners[i];
    const Vec2 to = p - corners[i];
    left += along.x() * to.y() - along.y() * to.x() > 0 ? 1 : 0;
  }
  return left == 0 || left == 4;
}

/// Returns the two axes normal to one.
std::pair<Vec3, Vec3> Across(const Mat3& R, int axis) {
  return {R.col((axis + 1) % 3), R.col((axis + 2) % 3)};
}

}  // namespace

std::optional<TriadPicture> DrawTriad(const CameraModel& camera, const Pose& X_WT) {
  const std::optional<Vec2> origin = camera.Project(X_WT.p);
  if (!origin) return std::nullopt;
  TriadPicture picture;
  picture.origin = *origin;
  picture.metres_per_px = camera.MetresPerPixelAt(X_WT.p);
  const Mat3 R = X_WT.q.toRotationMatrix();
  const Vec3 to_eye = (camera.eye_W() - X_WT.p).normalized();
  const auto at = [&](const Vec3& by_px) {
    return camera.Project(X_WT.p + picture.metres_per_px * by_px).value_or(*origin);
  };
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const Vec3 along = R.col(axis);
    picture.arrows[i] = {*origin, at(TriadPicture::kArrowPx * along)};
    picture.arrows[i].usable = (picture.arrows[i].to - *origin).norm() >= kShortestArrowPx;
    const auto [u, v] = Across(R, axis);
    const double near = TriadPicture::kSquareFrom * TriadPicture::kArrowPx;
    const double far = TriadPicture::kSquareTo * TriadPicture::kArrowPx;
    picture.squares[i] = {at(near * u + near * v), at(far * u + near * v), at(far * u + far * v),
                          at(near * u + far * v)};
    picture.square_usable[i] = std::abs(along.dot(to_eye)) >= kFlattest;
    // a ring about the line of sight is visible as a whole, any other ring by its near half
    const bool whole = std::abs(along.dot(to_eye)) > 0.98;
    std::vector<Vec2> front;
    std::vector<Vec2> before_gap;
    bool gap = false;
    for (int k = 0; k <= TriadPicture::kRingPoints; ++k) {
      const double angle = 2 * std::numbers::pi * k / TriadPicture::kRingPoints;
      const Vec3 r = std::cos(angle) * u + std::sin(angle) * v;
      if (!whole && r.dot(to_eye) < 0) {
        gap = true;
        continue;
      }
      (gap ? before_gap : front).push_back(at(TriadPicture::kRingPx * r));
    }
    // the near half may begin before the end of the round
    before_gap.insert(before_gap.end(), front.begin(), front.end());
    picture.rings[i] = std::move(before_gap);
  }
  return picture;
}

std::optional<TriadHandle> PickTriad(const TriadPicture& picture, const Vec2& px) {
  using Kind = TriadHandle::Kind;
  for (std::size_t i = 0; i < 3; ++i) {
    if (picture.square_usable[i] && Inside(picture.squares[i], px)) {
      return TriadHandle{Kind::kSquare, static_cast<int>(i)};
    }
  }
  double nearest = kReachPx;
  std::optional<TriadHandle> found;
  for (std::size_t i = 0; i < 3; ++i) {
    const TriadPicture::Arrow& arrow = picture.arrows[i];
    // its inner end belongs to the part, which can be dragged there
    const Vec2 from = arrow.from + TriadPicture::kSquareFrom * (arrow.to - arrow.from);
    const double distance = DistanceToSegment(px, from, arrow.to);
    if (!arrow.usable || distance > nearest) continue;
    nearest = distance;
    found = TriadHandle{Kind::kArrow, static_cast<int>(i)};
  }
  if (found) return found;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::vector<Vec2>& ring = picture.rings[i];
    for (std::size_t k = 0; k + 1 < ring.size(); ++k) {
      const double distance = DistanceToSegment(px, ring[k], ring[k + 1]);
      if (distance > nearest) continue;
      nearest = distance;
      found = TriadHandle{Kind::kRing, static_cast<int>(i)};
    }
  }
  return found;
}

DragManner BeginByHandle(const CameraModel& camera, const Pose& X_WT, const TriadHandle& handle,
                         bool axes_of_part, const Vec2& px, const Pose& X_WG, PartDrag& drag) {
  drag.Begin(px, X_WT.p, X_WG);
  drag.Lock(AxisLock{handle.axis, handle.kind == TriadHandle::Kind::kSquare, axes_of_part});
  if (handle.kind != TriadHandle::Kind::kRing) return {};
  // the ring's point under the cursor moves along the ring
  const std::optional<Vec2> origin = camera.Project(X_WT.p);
  const Mat3 R = X_WT.q.toRotationMatrix();
  const auto [u, v] = Across(R, handle.axis);
  const double radius = TriadPicture::kRingPx * camera.MetresPerPixelAt(X_WT.p);
  const Vec3 to_eye = (camera.eye_W() - X_WT.p).normalized();
  const bool whole = std::abs(R.col(handle.axis).dot(to_eye)) > 0.98;
  double nearest = 1e300;
  Vec2 along = Vec2::Zero();
  for (int k = 0; origin && k < 4 * TriadPicture::kRingPoints; ++k) {
    const double angle = 2 * std::numbers::pi * k / (4 * TriadPicture::kRingPoints);
    const Vec3 r = std::cos(angle) * u + std::sin(angle) * v;
    if (!whole && r.dot(to_eye) < 0) continue;
    const std::optional<Vec2> point = camera.Project(X_WT.p + radius * r);
    if (!point || (*point - px).norm() >= nearest) continue;
    nearest = (*point - px).norm();
    const Vec3 ahead = X_WT.p + radius * (r + 1e-3 * R.col(handle.axis).cross(r));
    along = 1e3 * (camera.Project(ahead).value_or(*point) - *point);
  }
  // limits the speed of a turn: a point hardly moves where the ring is seen from its edge
  const double px_per_rad = std::max(along.norm(), 0.5 * TriadPicture::kRingPx);
  if (!along.isZero()) drag.TurnAlong(along.normalized(), px_per_rad);
  return {.turn = true};
}

}  // namespace tandem
