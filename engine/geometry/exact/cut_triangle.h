#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "engine/geometry/exact/union_boundary.h"

namespace tandem {

/// One triangle with its own plane, and the traces of other triangles in that plane.
class CutTriangle {
 public:
  using Vec2 = Eigen::Vector2d;
  struct Segment {
    Vec2 from, to;
  };

  CutTriangle(const Vec3& a, const Vec3& b, const Vec3& c, double tolerance);

  bool flat() const { return flat_; }
  const Vec3& nhat() const { return nhat_; }
  double area() const { return 0.5 * (b_ - a_).cross(c_ - a_).norm(); }

  /// Tells whether the other triangle has at most one corner of both in common with this one, or
  /// lies beside it in its plane. `shared`: corner of the other that is also one of this one's; 3:
  /// none.
  bool IsApartFrom(const CutTriangle& other, std::size_t shared_here, std::size_t shared) const {
    return LiesBeside(other, shared) || other.LiesBeside(*this, shared_here);
  }

  /// Notes where the other triangle meets the plane of this one.
  void Meet(const Vec3& a, const Vec3& b, const Vec3& c);

  /// The sides of a place on which the union is.
  struct Sides {
    bool solid_in_front = false;
    bool solid_behind = false;
  };
  Sides SidesOfWhole(const std::function<bool(const Vec3&)>& solid) const {
    return SidesAt((a_ + b_ + c_) / 3, solid);
  }

  /// Adds the pieces that the segments cut it into, if they bound the union. `known`: the sides of
  /// all of them. With too much work, pieces are missing.
  void AddBoundary(const std::function<bool(const Vec3&)>& solid, const std::optional<Sides>& known,
                   bool sheets, std::uint32_t triangle, WorkShare& work,
                   std::vector<Facet>& facets) const;

 private:
  std::array<Vec3, 3> corners() const { return {a_, b_, c_}; }
  /// Tells whether the other's corners, without the shared one, are all on one side of this one's
  /// plane, or all beyond one of its edges. In the plane they may also be at the edge.
  bool LiesBeside(const CutTriangle& other, std::size_t shared) const;
  Sides SidesAt(const Vec3& place, const std::function<bool(const Vec3&)>& solid) const {
    return {solid(place + 2 * tolerance_ * nhat_), solid(place - 2 * tolerance_ * nhat_)};
  }
  Vec2 InPlane(const Vec3& p) const { return {u_.dot(p - a_), v_.dot(p - a_)}; }
  Vec3 InSpace(const Vec2& p) const { return a_ + p.x() * u_ + p.y() * v_; }
  void AddSegment(const Vec2& from, const Vec2& to);

  Vec3 a_, b_, c_;
  double tolerance_;
  bool flat_ = false;
  Vec3 nhat_, u_, v_;
  std::vector<Segment> segments_;
};

}  // namespace tandem
