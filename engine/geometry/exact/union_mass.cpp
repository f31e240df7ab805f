#include "engine/geometry/exact/union_mass.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "engine/geometry/exact/box_tree.h"
#include "engine/geometry/exact/union_boundary.h"
#include "engine/geometry/exact/winding_number.h"
#include "engine/geometry/mesh/mesh_sides.h"

namespace tandem {

namespace {

/// The sets of triangles that are connected across their sides.
struct Solids {
  std::vector<std::uint32_t> of_triangle;
  std::vector<Bounds> boxes;
};

Solids FindSolids(const TriangleMesh& mesh, const MeshSides& sides) {
  constexpr std::uint32_t kUnseen = ~0U;
  Solids solids;
  solids.of_triangle.assign(mesh.triangles.size(), kUnseen);
  std::vector<std::uint32_t> open;
  for (std::uint32_t first = 0; first < solids.of_triangle.size(); ++first) {
    if (solids.of_triangle[first] != kUnseen) continue;
    const auto solid = static_cast<std::uint32_t>(solids.boxes.size());
    solids.boxes.emplace_back();
    solids.of_triangle[first] = solid;
    open.assign(1, first);
    while (!open.empty()) {
      const std::uint32_t t = open.back();
      open.pop_back();
      for (std::uint32_t k = 0; k < 3; ++k) {
        solids.boxes.back().Add(mesh.corner(t, k));
        const std::uint32_t next = sides.NeighborAcross(t, k);
        if (next == MeshSides::kNone || solids.of_triangle[next] != kUnseen) continue;
        solids.of_triangle[next] = solid;
        open.push_back(next);
      }
    }
  }
  return solids;
}

/// Tells whether any two boxes have a volume in common; true also where there is too much work.
bool AnyOverlap(const std::vector<Bounds>& boxes, double tolerance, WorkBudget& budget) {
  const BoxTree tree = BuildBoxTree(boxes, 4);
  const auto overlap = [tolerance](const Bounds& a, const Bounds& b) {
    return (a.max.cwiseMin(b.max) - a.min.cwiseMax(b.min)).minCoeff() > tolerance;
  };
  WorkShare work(&budget);
  std::vector<std::uint32_t> open;
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    open.assign(1, 0);
    while (!open.empty()) {
      if (!work.Spend(1)) return true;
      const std::uint32_t at = open.back();
      open.pop_back();
      const BoxTree::Node& node = tree.nodes[at];
      if (!overlap(node.box, boxes[i])) continue;
      if (!node.leaf()) {
        open.push_back(node.right);
        open.push_back(at + 1);
        continue;
      }
      for (std::uint32_t k = node.first; k < node.first + node.count; ++k) {
        const std::uint32_t other = tree.order[k];
        if (other < i && overlap(boxes[other], boxes[i])) return true;
      }
    }
  }
  return false;
}

/// Tells whether any side belongs to more than two triangles, as all do where two solids of the
/// same corners lie exactly on one another.
bool AnySharedSide(const MeshSides& sides) {
  return std::ranges::any_of(sides.walls(), [](const MeshSides::Wall& wall) {
    return wall.count > 2;
  });
}

using FlatPolygon = std::vector<Vec3>;

/// Returns the part of a convex polygon on the side of a plane through p to which n points.
FlatPolygon PartAlong(const FlatPolygon& polygon, const Vec3& n, const Vec3& p) {
  FlatPolygon part;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3& from = polygon[i];
    const Vec3& to = polygon[(i + 1) % polygon.size()];
    const double d_from = n.dot(from - p);
    const double d_to = n.dot(to - p);
    if (d_from >= 0) part.push_back(from);
    if ((d_from < 0 && d_to > 0) || (d_from > 0 && d_to < 0)) {
      part.push_back(from + d_from / (d_from - d_to) * (to - from));
    }
  }
  return part.size() < 3 ? FlatPolygon() : part;
}

/// Takes a facet's area away from convex polygons that lie in its plane.
std::vector<FlatPolygon> Without(const std::vector<FlatPolygon>& polygons, const Facet& facet) {
  const std::array<Vec3, 3> corners{facet.a, facet.b, facet.c};
  const bool turned = (facet.b - facet.a).cross(facet.c - facet.a).dot(facet.nhat) < 0;
  std::vector<FlatPolygon> left;
  for (FlatPolygon polygon : polygons) {
    for (std::size_t k = 0; k < 3 && !polygon.empty(); ++k) {
      const Vec3 side = corners[(k + 1) % 3] - corners[k];
      const Vec3 inwards = (turned ? -1 : 1) * facet.nhat.cross(side);
      if (FlatPolygon outside = PartAlong(polygon, -inwards, corners[k]); !outside.empty()) {
        left.push_back(std::move(outside));
      }
      polygon = PartAlong(polygon, inwards, corners[k]);
    }
  }
  return left;
}

/// The surface of a union, as polygons of which no two lie on one another: faces of several solids
/// that lie in one plane, and face the same way, bound it together.
class UnionSurface {
 public:
  UnionSurface(std::vector<Facet> facets, const Solids& solids, double tolerance)
      : facets_(std::move(facets)), solids_(solids), tolerance_(tolerance) {
    // a piece without area has sides without a direction, along which nothing can be cut
    std::erase_if(facets_, [](const Facet& facet) {
      const Vec3 ab = facet.b - facet.a;
      const Vec3 ac = facet.c - facet.a;
      const double longest = std::max(ab.squaredNorm(), ac.squaredNorm());
      return facet.sheet || ab.cross(ac).norm() <= 1e-14 * longest;
    });
    for (const Facet& facet : facets_) {
      Bounds& box = boxes_.emplace_back();
      for (const Vec3& corner : {facet.a, facet.b, facet.c}) {
        box.Add(corner - Vec3::Constant(tolerance_));
        box.Add(corner + Vec3::Constant(tolerance_));
      }
    }
    tree_ = BuildBoxTree(boxes_, 4);
  }

  /// With too much work, it is not whole.
  TriangleMesh Mesh(WorkBudget& budget) const {
    TriangleMesh mesh;
    WorkShare work(&budget);
    for (std::uint32_t i = 0; i < facets_.size() && !budget.exceeded(); ++i) {
      const Facet& facet = facets_[i];
      std::vector<FlatPolygon> polygons{{facet.a, facet.b, facet.c}};
      for (const std::uint32_t earlier : EarlierOn(i, work)) {
        if (!work.Spend(polygons.size())) return mesh;
        polygons = Without(polygons, facets_[earlier]);
      }
      for (const FlatPolygon& polygon : polygons) Add(polygon, facet.nhat, mesh);
    }
    return mesh;
  }

 private:
  std::uint32_t SolidOf(std::uint32_t facet) const {
    return solids_.of_triangle[facets_[facet].triangle];
  }

  /// Returns earlier facets of other solids in a facet's plane, where they may lie on it.
  std::vector<std::uint32_t> EarlierOn(std::uint32_t i, WorkShare& work) const {
    constexpr double kSameWay = 1 - 1e-9;  // cosine
    std::vector<std::uint32_t> earlier;
    std::vector<std::uint32_t> open{0};
    while (!open.empty() && work.Spend(1)) {
      const std::uint32_t at = open.back();
      open.pop_back();
      const BoxTree::Node& node = tree_.nodes[at];
      if (!node.box.Overlaps(boxes_[i])) continue;
      if (!node.leaf()) {
        open.push_back(node.right);
        open.push_back(at + 1);
        continue;
      }
      for (std::uint32_t k = node.first; k < node.first + node.count; ++k) {
        const std::uint32_t other = tree_.order[k];
        if (other >= i || SolidOf(other) == SolidOf(i) || !boxes_[other].Overlaps(boxes_[i])) {
          continue;
        }
        const Vec3& nhat = facets_[i].nhat;
        const double apart = nhat.dot(facets_[other].a - facets_[i].a);
        if (facets_[other].nhat.dot(nhat) < kSameWay || std::abs(apart) > tolerance_) continue;
        earlier.push_back(other);
      }
    }
    return earlier;
  }

  static void Add(const FlatPolygon& polygon, const Vec3& nhat, TriangleMesh& mesh) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), polygon.begin(), polygon.end());
    Vec3 area = Vec3::Zero();
    for (std::size_t k = 2; k < polygon.size(); ++k) {
      area += (polygon[k - 1] - polygon[0]).cross(polygon[k] - polygon[0]);
    }
    const bool turned = area.dot(nhat) < 0;
    for (std::uint32_t k = 2; k < polygon.size(); ++k) {
      mesh.triangles.push_back({first, first + (turned ? k : k - 1), first + (turned ? k - 1 : k)});
    }
  }

  std::vector<Facet> facets_;
  const Solids& solids_;
  double tolerance_;
  std::vector<Bounds> boxes_;
  BoxTree tree_;
};

/// Returns the surface that bounds the union of the mesh's solids. With too much work, it is not
/// whole.
TriangleMesh BoundaryOf(const TriangleMesh& outward, const MeshSides& sides, const Solids& solids,
                        WorkBudget& budget) {
  const WindingNumber winding(outward);
  const auto solid = [&](const Vec3& p) {
    if (budget.exceeded()) return false;
    std::size_t steps = 0;
    const bool inside = winding.At(p, steps) >= 0.5;
    budget.Spend(steps);
    return inside;
  };
  // cracks close by their winding number, which changes at no triangle
  const MeshSides* patches = sides.walls().empty() ? &sides : nullptr;
  std::vector<Facet> facets = UnionBoundaryAndSheets(outward, patches, solid, &budget);
  if (budget.exceeded() || facets.empty()) return {};
  return UnionSurface(std::move(facets), solids, CoincidenceTolerance(outward)).Mesh(budget);
}

/// Returns the mesh with its bodies turned outward, after all of it is turned where it faces
/// inwards as a whole, so that its cavities stay cavities.
TriangleMesh Outward(const TriangleMesh& mesh, bool inwards) {
  if (!inwards) return OrientBodiesOutward(mesh);
  TriangleMesh turned = mesh;
  for (TriangleMesh::Triangle& t : turned.triangles) std::swap(t[1], t[2]);
  return OrientBodiesOutward(turned);
}

/// Tells whether some bodies of a mesh face another way than the others.
bool AnyTurned(const TriangleMesh& outward, const TriangleMesh& mesh, bool inwards) {
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const TriangleMesh::Triangle& as_wound = mesh.triangles[t];
    const bool same = outward.triangles[t] == as_wound;
    if (same == inwards && as_wound[1] != as_wound[2]) return true;
  }
  return false;
}

}  // namespace

UnionMass ComputeUnionMass(const TriangleMesh& mesh, std::uint64_t most_work) {
  constexpr double kSame = 1e-6;  // share of the volume that the cuts may round away
  const MassProperties as_wound = ComputeMassProperties(mesh);
  const bool inwards = as_wound.volume < 0;
  const TriangleMesh outward = Outward(mesh, inwards);
  UnionMass plain{as_wound};
  if (AnyTurned(outward, mesh, inwards)) plain = {ComputeMassProperties(outward)};
  if (!plain.solid) return {as_wound};
  plain.volume = std::copysign(plain.volume, as_wound.volume);
  WorkBudget budget(most_work);
  const MeshSides sides(outward);
  const Solids solids = FindSolids(outward, sides);
  const bool meet =
      AnySharedSide(sides) || AnyOverlap(solids.boxes, CoincidenceTolerance(mesh), budget);
  if (!meet) return plain;
  const TriangleMesh boundary =
      budget.exceeded() ? TriangleMesh() : BoundaryOf(outward, sides, solids, budget);
  plain.counts_twice = true;
  if (budget.exceeded() || boundary.triangles.empty()) return plain;
  UnionMass whole{ComputeBoundedMass(boundary)};
  if (!whole.solid) return plain;
  plain.counts_twice = false;
  if (std::abs(whole.volume - std::abs(plain.volume)) <= kSame * whole.volume) return plain;
  whole.volume = std::copysign(whole.volume, plain.volume);
  return whole;
}

}  // namespace tandem
