#include "engine/geometry/exact/cut_triangle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace tandem {
namespace {

using Vec2 = Eigen::Vector2d;
using Polygon = std::vector<Vec2>;  // convex, counter-clockwise
using Segment = CutTriangle::Segment;

double Cross(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Tells whether the segment runs through the polygon's inside, at least `tolerance` from its edges
/// and for at least `tolerance`.
bool Crosses(const Segment& segment, const Polygon& polygon, double tolerance) {
  double begin = 0;
  double end = 1;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2& corner = polygon[i];
    const Vec2 edge = polygon[(i + 1) % polygon.size()] - corner;
    const double length = edge.norm();
    if (length == 0) continue;
    const double from = Cross(edge, segment.from - corner) / length - tolerance;
    const double to = Cross(edge, segment.to - corner) / length - tolerance;
    if (from <= 0 && to <= 0) return false;
    if (from < 0) begin = std::max(begin, from / (from - to));
    if (to < 0) end = std::min(end, from / (from - to));
  }
  return (end - begin) * (segment.to - segment.from).norm() > tolerance;
}

/// Cuts the polygon along the segment's line, into the part left of it and the part right of it.
std::array<Polygon, 2> Cut(const Polygon& polygon, const Segment& segment) {
  const Vec2 along = (segment.to - segment.from).normalized();
  std::array<Polygon, 2> halves;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2& p = polygon[i];
    const Vec2& q = polygon[(i + 1) % polygon.size()];
    const double left_p = Cross(along, p - segment.from);
    const double left_q = Cross(along, q - segment.from);
    if (left_p >= 0) halves[0].push_back(p);
    if (left_p <= 0) halves[1].push_back(p);
    if ((left_p > 0 && left_q < 0) || (left_p < 0 && left_q > 0)) {
      const Vec2 cut = p + (left_p / (left_p - left_q)) * (q - p);
      halves[0].push_back(cut);
      halves[1].push_back(cut);
    }
  }
  return halves;
}

}  // namespace

CutTriangle::CutTriangle(const Vec3& a, const Vec3& b, const Vec3& c, double tolerance)
    : a_(a), b_(b), c_(c), tolerance_(tolerance) {
  const Vec3 normal = (b - a).cross(c - a);
  const double longest =
      std::max({(b - a).squaredNorm(), (c - a).squaredNorm(), (c - b).squaredNorm()});
  flat_ = normal.norm() <= 1e-14 * longest;
  if (flat_) return;
  nhat_ = normal.normalized();
  u_ = (b - a).normalized();
  v_ = nhat_.cross(u_);
}

void CutTriangle::Meet(const Vec3& a, const Vec3& b, const Vec3& c) {
  const std::array<Vec3, 3> other{a, b, c};
  std::array<double, 3> height;
  for (std::size_t k = 0; k < 3; ++k) {
    height[k] = nhat_.dot(other[k] - a_);
    if (std::abs(height[k]) <= tolerance_) height[k] = 0;
  }
  std::array<Vec2, 6> ends;
  std::size_t count = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    if (height[k] == 0 && height[next] == 0) AddSegment(InPlane(other[k]), InPlane(other[next]));
    if (height[k] == 0) ends[count++] = InPlane(other[k]);
    if (height[k] * height[next] < 0) {
      const double share = height[k] / (height[k] - height[next]);
      ends[count++] = InPlane(other[k] + share * (other[next] - other[k]));
    }
  }
  const bool has_edge_in_plane = (height[0] == 0) + (height[1] == 0) + (height[2] == 0) >= 2;
  if (count == 2 && !has_edge_in_plane) AddSegment(ends[0], ends[1]);
}

void CutTriangle::AddBoundary(const std::function<bool(const Vec3&)>& solid,
                              const std::optional<Sides>& known, bool sheets,
                              std::uint32_t triangle, WorkShare& work,
                              std::vector<Facet>& facets) const {
  constexpr std::uint64_t kOfPiece = 100;  // work of a piece by itself, and a bound on its memory
  std::vector<Polygon> pieces{{InPlane(a_), InPlane(b_), InPlane(c_)}};
  for (const Segment& segment : segments_) {
    const std::size_t count = pieces.size();
    if (!work.Spend(count)) return;
    for (std::size_t i = 0; i < count; ++i) {
      if (!Crosses(segment, pieces[i], tolerance_)) continue;
      std::array<Polygon, 2> halves = Cut(pieces[i], segment);
      pieces[i] = std::move(halves[0]);
      pieces.push_back(std::move(halves[1]));
    }
  }
  for (const Polygon& piece : pieces) {
    if (!work.Spend(kOfPiece)) return;
    if (piece.size() < 3) continue;
    const Vec2 sum = std::accumulate(piece.begin(), piece.end(), Vec2(Vec2::Zero()));
    const Vec3 centre = InSpace(sum / static_cast<double>(piece.size()));
    const auto [solid_in_front, solid_behind] = known ? *known : SidesAt(centre, solid);
    const bool sheet = sheets && !solid_in_front && !solid_behind;
    if (solid_in_front == solid_behind && !sheet) continue;
    const Vec3 nhat = solid_in_front ? Vec3(-nhat_) : nhat_;
    if (pieces.size() == 1) {
      facets.push_back({a_, b_, c_, nhat, sheet, triangle});
      continue;
    }
    for (std::size_t k = 2; k < piece.size(); ++k) {
      facets.push_back({InSpace(piece[0]), InSpace(piece[k - 1]), InSpace(piece[k]), nhat, sheet,
                        triangle, false});
    }
  }
}

bool CutTriangle::LiesBeside(const CutTriangle& other, std::size_t shared) const {
  const std::array<Vec3, 3> theirs = other.corners();
  double least = std::numeric_limits<double>::infinity();
  double most = -least;
  for (std::size_t k = 0; k < 3; ++k) {
    if (k == shared) continue;
    const double height = nhat_.dot(theirs[k] - a_);
    least = std::min(least, height);
    most = std::max(most, height);
  }
  if (least > tolerance_ || most < -tolerance_) return true;
  const bool in_plane = least >= -tolerance_ && most <= tolerance_;
  const double at_most = in_plane ? tolerance_ : -tolerance_;
  const std::array<Vec3, 3> here = corners();
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 inward = nhat_.cross(here[(k + 1) % 3] - here[k]).normalized();
    bool beyond = true;
    for (std::size_t i = 0; i < 3; ++i) {
      if (i != shared) beyond = beyond && inward.dot(theirs[i] - here[k]) <= at_most;
    }
    if (beyond) return true;
  }
  return false;
}

void CutTriangle::AddSegment(const Vec2& from, const Vec2& to) {
  const Polygon whole{InPlane(a_), InPlane(b_), InPlane(c_)};
  if (Crosses({from, to}, whole, tolerance_)) segments_.push_back({from, to});
}

}  // namespace tandem
