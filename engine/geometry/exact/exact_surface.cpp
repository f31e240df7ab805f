#include "engine/geometry/exact/exact_surface.h"

#include <cmath>

#include "engine/base/check.h"
#include "engine/geometry/exact/tree_pair.h"
#include "engine/geometry/mesh/closest_on_triangle.h"

namespace tandem {

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
