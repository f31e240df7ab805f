#include "engine/geometry/exact/exact_surface.h"

#include <algorithm>
#include <cmath>

#include "engine/base/check.h"
#include "engine/geometry/exact/tree_pair.h"
#include "engine/geometry/mesh/closest_on_triangle.h"

namespace tandem {
namespace {

/// Tells whether a plane separates two triangles by more than `gap` (m): one of either triangle, or
/// one along an edge of each.
bool AreApart(const std::array<Vec3, 3>& one, const std::array<Vec3, 3>& other, double gap) {
  const auto separates = [&](const Vec3& normal) {
    const double length = normal.norm();
    if (!(length > 0)) return false;
    double least_one = std::numeric_limits<double>::infinity();
    double least_other = least_one;
    double most_one = -least_one;
    double most_other = -least_one;
    for (std::size_t i = 0; i < 3; ++i) {
      const double a = normal.dot(one[i] - one[0]);
      const double b = normal.dot(other[i] - one[0]);
      least_one = std::min(least_one, a);
      most_one = std::max(most_one, a);
      least_other = std::min(least_other, b);
      most_other = std::max(most_other, b);
    }
    return std::max(least_one - most_other, least_other - most_one) > gap * length;
  };
  const auto edge = [](const std::array<Vec3, 3>& triangle, std::size_t i) {
    return Vec3(triangle[(i + 1) % 3] - triangle[i]);
  };
  if (separates(edge(one, 0).cross(edge(one, 1)))) return true;
  if (separates(edge(other, 0).cross(edge(other, 1)))) return true;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      if (separates(edge(one, i).cross(edge(other, j)))) return true;
    }
  }
  return false;
}

}  // namespace

ExactSurface::ExactSurface(const TriangleMesh& mesh)
    : ExactSurface(OutwardOriented{OrientBodiesOutward(mesh)}) {}

ExactSurface::ExactSurface(const OutwardOriented& turned_out)
    : tolerance_(CoincidenceTolerance(turned_out.mesh)), winding_(turned_out.mesh) {
  const std::vector<Facet> facets = UnionBoundary(turned_out.mesh, winding_);
  std::vector<Bounds> boxes(facets.size());
  for (std::size_t i = 0; i < facets.size(); ++i) {
    for (const Vec3& corner : {facets[i].a, facets[i].b, facets[i].c}) boxes[i].Add(corner);
  }
  tree_ = BuildBoxTree(boxes, 4);
  facets_.reserve(facets.size());
  for (const std::uint32_t i : tree_.order) facets_.push_back(facets[i]);
}

ExactSurface::Closest ExactSurface::Search(const Vec3& p, double cut_off) const {
  Closest closest{.squared_distance = cut_off * cut_off};
  VisitNearLeaves(tree_, p, closest.squared_distance, [&](const BoxTree::Node& leaf) {
    for (std::uint32_t i = leaf.first; i < leaf.first + leaf.count; ++i) {
      const Facet& facet = facets_[i];
      const OnTriangle candidate = ClosestOnTriangle(facet.a, facet.b, facet.c, p);
      const double squared = (candidate.point - p).squaredNorm();
      if (squared < closest.squared_distance) {
        closest = {squared, candidate.point, i, candidate.on_face};
      }
    }
    return closest.squared_distance;
  });
  return closest;
}

double ExactSurface::Distance(const Vec3& p, double cut_off) const {
  return std::sqrt(Search(p, cut_off).squared_distance);
}

Vec3 ExactSurface::ClosestPoint(const Vec3& p) const {
  TANDEM_CHECK(!empty());
  return Search(p, std::numeric_limits<double>::infinity()).point;
}

const Facet& ExactSurface::ClosestFacet(const Vec3& p) const {
  TANDEM_CHECK(!empty());
  return facets_[Search(p, std::numeric_limits<double>::infinity()).facet];
}

bool ExactSurface::MayMeet(const std::array<Vec3, 3>& corners) const {
  if (empty()) return false;
  // a little larger than the triangle, as facets are known to the tolerance
  const double gap = 4 * tolerance_;
  Bounds box;
  for (const Vec3& corner : corners) {
    box.Add(corner + Vec3::Constant(gap));
    box.Add(corner - Vec3::Constant(gap));
  }
  std::array<std::uint32_t, BoxTree::kMaxDepth + 1> stack{};
  std::size_t depth = 1;  // the root is open
  while (depth > 0) {
    const std::uint32_t at = stack[--depth];
    const BoxTree::Node& node = tree_.nodes[at];
    if (!node.box.Overlaps(box)) continue;
    if (!node.leaf()) {
      stack[depth++] = at + 1;
      stack[depth++] = node.right;
      continue;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      if (!AreApart(corners, {facets_[i].a, facets_[i].b, facets_[i].c}, gap)) return true;
    }
  }
  return false;
}

double ExactSurface::Depth(const Vec3& p, const Hint& hint) const {
  if (empty()) return -std::numeric_limits<double>::infinity();
  // a little more than the hint, because the closest point itself must be found
  const Closest closest = Search(p, hint.at_most * (1 + 1e-6) + tolerance_);
  const double distance = std::sqrt(closest.squared_distance);
  if (hint.side != Side::kUnknown) return hint.side == Side::kInside ? distance : -distance;
  // There is no surface between p and its closest point. So if that lies on the face of a facet,
  // the facet's side decides, unless p is too near for its normal to be reliable.
  if (closest.on_face && distance > 4 * tolerance_) {
    const double in_front = facets_[closest.facet].nhat.dot(p - closest.point);
    if (std::abs(in_front) > 0.9999 * distance) return in_front > 0 ? -distance : distance;
  }
  const bool inside = distance > 8 * tolerance_ ? SolidAt(p) : Contains(p);
  return inside ? distance : -distance;
}

// Does as Contains(), away from the surface, but is not deceived by a p just between two bodies
// that touch, or on a sheet: two of three places decide.
bool ExactSurface::SolidAt(const Vec3& p) const {
  const Vec3 aside = 4 * tolerance_ * Vec3(0.48, 0.60, 0.64);
  const bool first = Contains(p + aside);
  return first == Contains(p - aside) ? first : Contains(p);
}

}  // namespace tandem
