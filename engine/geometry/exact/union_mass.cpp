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

/// Tells whether any two boxes have a volume in common.
bool AnyOverlap(std::vector<Bounds> boxes, double tolerance) {
  std::ranges::sort(boxes, {}, [](const Bounds& box) {
    return box.min.x();
  });
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    for (std::size_t j = i + 1; j < boxes.size(); ++j) {
      if (boxes[j].min.x() >= boxes[i].max.x() - tolerance) break;
      const Vec3 common = boxes[i].max.cwiseMin(boxes[j].max) - boxes[i].min.cwiseMax(boxes[j].min);
      if (common.minCoeff() > tolerance) return true;
    }
  }
  return false;
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
    std::erase_if(facets_, [](const Facet& facet) {
      return facet.sheet;
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

  TriangleMesh Mesh() const {
    TriangleMesh mesh;
    for (std::uint32_t i = 0; i < facets_.size(); ++i) {
      const Facet& facet = facets_[i];
      std::vector<FlatPolygon> polygons{{facet.a, facet.b, facet.c}};
      for (const std::uint32_t earlier : EarlierOn(i))
        polygons = Without(polygons, facets_[earlier]);
      for (const FlatPolygon& polygon : polygons) Add(polygon, facet.nhat, mesh);
    }
    return mesh;
  }

 private:
  std::uint32_t SolidOf(std::uint32_t facet) const {
    return solids_.of_triangle[facets_[facet].triangle];
  }

  /// Returns earlier facets of other solids in a facet's plane, where they may lie on it.
  std::vector<std::uint32_t> EarlierOn(std::uint32_t i) const {
    constexpr double kSameWay = 1 - 1e-9;  // cosine
    std::vector<std::uint32_t> earlier;
    std::vector<std::uint32_t> open{0};
    while (!open.empty()) {
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

/// Returns the surface that bounds the union of the mesh's solids.
TriangleMesh BoundaryOf(const TriangleMesh& outward, const MeshSides& sides, const Solids& solids) {
  const WindingNumber winding(outward);
  // cracks close by their winding number, which changes at no triangle
  const MeshSides* patches = sides.walls().empty() ? &sides : nullptr;
  std::vector<Facet> facets = UnionBoundaryAndSheets(outward, patches, [&](const Vec3& p) {
    return winding.At(p) >= 0.5;
  });
  return UnionSurface(std::move(facets), solids, CoincidenceTolerance(outward)).Mesh();
}

}  // namespace

MassProperties ComputeUnionMass(const TriangleMesh& mesh) {
  constexpr double kSame = 1e-6;  // share of the volume that the cuts may round away
  MassProperties plain = ComputeMassProperties(mesh);
  if (!plain.solid) return plain;
  const TriangleMesh outward = OrientBodiesOutward(mesh);
  const MeshSides sides(outward);
  const Solids solids = FindSolids(outward, sides);
  if (!AnyOverlap(solids.boxes, CoincidenceTolerance(mesh))) return plain;
  const TriangleMesh boundary = BoundaryOf(outward, sides, solids);
  if (boundary.triangles.empty()) return plain;
  MassProperties whole = ComputeBoundedMass(boundary);
  if (!whole.solid || std::abs(whole.volume - std::abs(plain.volume)) <= kSame * whole.volume) {
    return plain;
  }
  whole.volume = std::copysign(whole.volume, plain.volume);
  return whole;
}

}  // namespace tandem
