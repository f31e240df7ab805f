#include "engine/geometry/exact/union_boundary.h"

#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include <tbb/parallel_for.h>

#include "engine/geometry/exact/box_tree.h"
#include "engine/geometry/exact/cut_triangle.h"

namespace tandem {
namespace {

// The corners that two triangles have in common.
struct SharedCorners {
  std::size_t count = 0;
  std::size_t here = 3, there = 3;  // the last of them, in either
};
SharedCorners CornersSharedBy(const TriangleMesh::Triangle& t,
                              const TriangleMesh::Triangle& other) {
  SharedCorners shared;
  for (std::size_t here = 0; here < 3; ++here) {
    for (std::size_t there = 0; there < 3; ++there) {
      if (t[here] == other[there]) shared = {shared.count + 1, here, there};
    }
  }
  return shared;
}

std::vector<std::uint32_t> BodyOfVertex(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto root = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const TriangleMesh::Triangle& t : mesh.triangles) {
    parent[root(t[1])] = root(t[0]);
    parent[root(t[2])] = root(t[0]);
  }
  for (std::uint32_t i = 0; i < parent.size(); ++i) parent[i] = root(i);
  return parent;
}

/// Sorts a mesh's triangles into the pieces that bound a union.
class Pieces {
 public:
  using Solid = std::function<bool(const Vec3&)>;

  Pieces(const TriangleMesh& mesh, const Solid& solid, bool sheets, WorkBudget* budget)
      : mesh_(mesh),
        solid_(solid),
        sheets_(sheets),
        budget_(budget),
        tolerance_(CoincidenceTolerance(mesh)) {
    boxes_.resize(mesh.triangles.size());
    for (std::size_t t = 0; t < boxes_.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        boxes_[t].Add(mesh.corner(t, k) - Vec3::Constant(tolerance_));
        boxes_[t].Add(mesh.corner(t, k) + Vec3::Constant(tolerance_));
      }
    }
    tree_ = BuildBoxTree(boxes_, 4);
  }

  /// Finds the pieces. `sides`, or null: as UnionBoundaryAndSheets.
  std::vector<Facet> Find(const MeshSides* sides) const {
    std::vector<std::optional<CutTriangle::Sides>> known(boxes_.size());
    if (sides != nullptr) known = AskPatches(*sides);
    std::vector<std::vector<Facet>> facets_of(boxes_.size());
    tbb::parallel_for(std::size_t{0}, boxes_.size(), [&](std::size_t t) {
      CutTriangle cut = TriangleAt(t);
      if (cut.flat() || IsExceeded()) return;
      WorkShare work(budget_);
      if (!known[t]) {
        VisitMet(t, work, [&](std::size_t other, const SharedCorners&) {
          cut.Meet(mesh_.corner(other, 0), mesh_.corner(other, 1), mesh_.corner(other, 2));
          return true;
        });
      }
      cut.AddBoundary(solid_, known[t], sheets_, static_cast<std::uint32_t>(t), work, facets_of[t]);
    });
    std::vector<Facet> facets;
    for (const std::vector<Facet>& some : facets_of)
      facets.insert(facets.end(), some.begin(), some.end());
    return facets;
  }

 private:
  bool IsExceeded() const { return budget_ != nullptr && budget_->exceeded(); }

  CutTriangle TriangleAt(std::size_t t) const {
    return {mesh_.corner(t, 0), mesh_.corner(t, 1), mesh_.corner(t, 2), tolerance_};
  }

  /// Calls `visit(other, shared)` for triangles whose boxes overlap that of a triangle, except
  /// those that share an edge with it, until it returns false or there is too much work.
  template <typename Visit>
  void VisitMet(std::size_t t, WorkShare& work, const Visit& visit) const {
    std::vector<std::uint32_t> open{0};
    while (!open.empty() && work.Spend(1)) {
      const std::uint32_t i = open.back();
      open.pop_back();
      const BoxTree::Node& node = tree_.nodes[i];
      if (!node.box.Overlaps(boxes_[t])) continue;
      if (!node.leaf()) {
        open.push_back(node.right);
        open.push_back(i + 1);
        continue;
      }
      for (std::uint32_t k = node.first; k < node.first + node.count; ++k) {
        const std::uint32_t other = tree_.order[k];
        if (!boxes_[other].Overlaps(boxes_[t])) continue;
        const SharedCorners shared = CornersSharedBy(mesh_.triangles[t], mesh_.triangles[other]);
        if (shared.count < 2 && !visit(other, shared)) return;
      }
    }
  }

  /// Tells whether a triangle meets others only at corners and along edges that it shares with
  /// them.
  bool IsAlone(std::size_t t) const {
    WorkShare work(budget_);
    const CutTriangle here = TriangleAt(t);
    if (here.flat()) return false;
    bool alone = true;
    VisitMet(t, work, [&](std::size_t other, const SharedCorners& shared) {
      const CutTriangle there = TriangleAt(other);
      alone = !there.flat() && here.IsApartFrom(there, shared.here, shared.there);
      return alone;
    });
    return alone;
  }

  /// Finds the sides of triangles that are alone. One call for the largest decides for all that are
  /// connected.
  std::vector<std::optional<CutTriangle::Sides>> AskPatches(const MeshSides& sides) const {
    // a patch that is folded back onto itself encloses nothing
    constexpr double kFolded = -0.99;  // cosine
    const std::size_t count = boxes_.size();
    std::vector<std::uint8_t> alone(count);
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t t) {
      alone[t] = !IsExceeded() && IsAlone(t) ? 1 : 0;
    });
    std::vector<std::uint32_t> patch_of(count, MeshSides::kNone);
    std::vector<std::uint32_t> largest;  // per patch
    std::vector<std::uint32_t> open;
    for (std::uint32_t first = 0; first < count; ++first) {
      if (alone[first] == 0 || patch_of[first] != MeshSides::kNone) continue;
      const auto patch = static_cast<std::uint32_t>(largest.size());
      largest.push_back(first);
      double most = 0;
      open.push_back(first);
      patch_of[first] = patch;
      while (!open.empty()) {
        const std::uint32_t t = open.back();
        open.pop_back();
        const CutTriangle here = TriangleAt(t);
        if (here.area() > most) {
          most = here.area();
          largest[patch] = t;
        }
        for (std::uint32_t k = 0; k < 3; ++k) {
          const std::uint32_t other = sides.NeighborAcross(t, k);
          if (other == MeshSides::kNone || alone[other] == 0) continue;
          if (patch_of[other] != MeshSides::kNone) continue;
          if (TriangleAt(other).nhat().dot(here.nhat()) < kFolded) continue;
          patch_of[other] = patch;
          open.push_back(other);
        }
      }
    }
    std::vector<CutTriangle::Sides> patch_sides(largest.size());
    tbb::parallel_for(std::size_t{0}, largest.size(), [&](std::size_t patch) {
      patch_sides[patch] = TriangleAt(largest[patch]).SidesOfWhole(solid_);
    });
    std::vector<std::optional<CutTriangle::Sides>> known(count);
    for (std::size_t t = 0; t < count; ++t) {
      if (patch_of[t] != MeshSides::kNone) known[t] = patch_sides[patch_of[t]];
    }
    return known;
  }

  const TriangleMesh& mesh_;
  const Solid& solid_;
  bool sheets_;
  WorkBudget* budget_;
  double tolerance_;
  std::vector<Bounds> boxes_;
  BoxTree tree_;
};

}  // namespace

double CoincidenceTolerance(const TriangleMesh& mesh) {
  return 1e-6 * BoundsOf(mesh).size().norm();
}

TriangleMesh OrientBodiesOutward(const TriangleMesh& mesh) {
  struct Body {
    double volume = 0;
    double area = 0;
    Vec3 area_vector = Vec3::Zero();  // zero if closed, T-junction cracks or not
    std::vector<std::size_t> triangles;
  };
  const std::vector<std::uint32_t> body_of = BodyOfVertex(mesh);
  std::vector<Body> bodies(mesh.vertices.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t root = body_of[mesh.triangles[t][0]];
    const Vec3& origin = mesh.vertices[root];
    const Vec3 a = mesh.corner(t, 0) - origin;
    const Vec3 b = mesh.corner(t, 1) - origin;
    const Vec3 c = mesh.corner(t, 2) - origin;
    const Vec3 area_vector = 0.5 * (b - a).cross(c - a);
    bodies[root].volume += a.dot(b.cross(c)) / 6.0;
    bodies[root].area += area_vector.norm();
    bodies[root].area_vector += area_vector;
    bodies[root].triangles.push_back(t);
  }
  // a cavity lies in some other body, a body turned inside out does not: three of its corners
  // decide
  const WindingNumber all(mesh);
  const auto in_another = [&](const Body& body) {
    int votes = 0;
    const std::size_t last = body.triangles.size() - 1;
    for (const std::size_t k : {std::size_t{0}, last / 2, last}) {
      const Vec3& corner = mesh.corner(body.triangles[k], 0);
      double others = all.At(corner);
      for (const std::size_t t : body.triangles) {
        others -= WindingOf(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), corner);
      }
      votes += others >= 0.5 ? 1 : 0;
    }
    return votes >= 2;
  };
  TriangleMesh turned = mesh;
  for (const Body& body : bodies) {
    const bool closed = body.area_vector.norm() <= 1e-6 * body.area;
    if (body.volume >= 0 || !closed || in_another(body)) continue;
    for (const std::size_t t : body.triangles)
      std::swap(turned.triangles[t][1], turned.triangles[t][2]);
  }
  return turned;
}

std::vector<Facet> UnionBoundary(const TriangleMesh& mesh, const WindingNumber& winding) {
  const auto solid = [&winding](const Vec3& p) {
    return winding.At(p) >= 0.5;
  };
  return Pieces(mesh, solid, false, nullptr).Find(nullptr);
}

std::vector<Facet> UnionBoundaryAndSheets(const TriangleMesh& mesh, const MeshSides* sides,
                                          const std::function<bool(const Vec3&)>& solid,
                                          WorkBudget* budget) {
  return Pieces(mesh, solid, true, budget).Find(sides);
}

}  // namespace tandem
