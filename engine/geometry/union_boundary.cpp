#include "engine/geometry/union_boundary.h"

#include <array>
#include <cmath>
#include <numeric>

#include <tbb/parallel_for.h>

#include "engine/geometry/box_tree.h"

namespace tandem {
namespace {

using Vec2 = Eigen::Vector2d;
using Polygon = std::vector<Vec2>;  // convex, counter-clockwise

struct Segment {
  Vec2 from, to;
};

double Cross(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// Whether the segment runs through the polygon's inside, at least `tolerance` from its edges and
// for at least `tolerance`.
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

// Cuts the polygon along the segment's line: what lies left of it, and right.
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

// One triangle with a plane of its own, and what other triangles leave in that plane.
class CutTriangle {
 public:
  CutTriangle(const Vec3& a, const Vec3& b, const Vec3& c, double tolerance)
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

  bool flat() const { return flat_; }

  // Notes where the other triangle meets the plane of this one.
  void Meet(const std::array<Vec3, 3>& other) {
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

  // The pieces that the segments cut it into, bounding the union or not.
  void AddBoundary(const std::function<bool(const Vec3&)>& solid, bool sheets,
                   std::vector<Facet>& facets) const {
    std::vector<Polygon> pieces{{InPlane(a_), InPlane(b_), InPlane(c_)}};
    for (const Segment& segment : segments_) {
      const std::size_t count = pieces.size();
      for (std::size_t i = 0; i < count; ++i) {
        if (!Crosses(segment, pieces[i], tolerance_)) continue;
        std::array<Polygon, 2> halves = Cut(pieces[i], segment);
        pieces[i] = std::move(halves[0]);
        pieces.push_back(std::move(halves[1]));
      }
    }
    for (const Polygon& piece : pieces) {
      if (piece.size() < 3) continue;
      const Vec2 sum = std::accumulate(piece.begin(), piece.end(), Vec2(Vec2::Zero()));
      const Vec3 centre = InSpace(sum / static_cast<double>(piece.size()));
      const bool solid_in_front = solid(centre + 2 * tolerance_ * nhat_);
      const bool solid_behind = solid(centre - 2 * tolerance_ * nhat_);
      const bool sheet = sheets && !solid_in_front && !solid_behind;
      if (solid_in_front == solid_behind && !sheet) continue;
      const Vec3 nhat = solid_in_front ? Vec3(-nhat_) : nhat_;
      if (pieces.size() == 1) {
        facets.push_back({a_, b_, c_, nhat, sheet});
        continue;
      }
      for (std::size_t k = 2; k < piece.size(); ++k) {
        facets.push_back(
            {InSpace(piece[0]), InSpace(piece[k - 1]), InSpace(piece[k]), nhat, sheet});
      }
    }
  }

 private:
  Vec2 InPlane(const Vec3& p) const { return {u_.dot(p - a_), v_.dot(p - a_)}; }
  Vec3 InSpace(const Vec2& p) const { return a_ + p.x() * u_ + p.y() * v_; }
  void AddSegment(const Vec2& from, const Vec2& to) {
    const Polygon whole{InPlane(a_), InPlane(b_), InPlane(c_)};
    if (Crosses({from, to}, whole, tolerance_)) segments_.push_back({from, to});
  }

  Vec3 a_, b_, c_;
  double tolerance_;
  bool flat_ = false;
  Vec3 nhat_, u_, v_;
  std::vector<Segment> segments_;
};

std::size_t SharedCorners(const TriangleMesh::Triangle& t, const TriangleMesh::Triangle& other) {
  std::size_t shared = 0;
  for (const std::uint32_t i : t) shared += std::count(other.begin(), other.end(), i) > 0 ? 1 : 0;
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

/// The pieces of the mesh's triangles with the union on one side, and with `sheets` those with free
/// space on both.
std::vector<Facet> PiecesOf(const TriangleMesh& mesh, const std::function<bool(const Vec3&)>& solid,
                            bool sheets) {
  const double tolerance = CoincidenceTolerance(mesh);
  std::vector<Bounds> boxes(mesh.triangles.size());
  for (std::size_t t = 0; t < boxes.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      boxes[t].Add(mesh.corner(t, k) - Vec3::Constant(tolerance));
      boxes[t].Add(mesh.corner(t, k) + Vec3::Constant(tolerance));
    }
  }
  const BoxTree tree = BuildBoxTree(boxes, 4);
  const auto corners = [&](std::size_t t) {
    return std::array<Vec3, 3>{mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)};
  };
  std::vector<std::vector<Facet>> facets_of(boxes.size());
  tbb::parallel_for(std::size_t{0}, boxes.size(), [&](std::size_t t) {
    CutTriangle cut(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), tolerance);
    if (cut.flat()) return;
    std::vector<std::uint32_t> open{0};
    while (!open.empty()) {
      const std::uint32_t i = open.back();
      open.pop_back();
      const BoxTree::Node& node = tree.nodes[i];
      if (!node.box.Overlaps(boxes[t])) continue;
      if (!node.leaf()) {
        open.push_back(node.right);
        open.push_back(i + 1);
        continue;
      }
      for (std::uint32_t k = node.first; k < node.first + node.count; ++k) {
        const std::uint32_t other = tree.order[k];
        if (!boxes[other].Overlaps(boxes[t])) continue;
        if (SharedCorners(mesh.triangles[t], mesh.triangles[other]) >= 2) continue;
        cut.Meet(corners(other));
      }
    }
    cut.AddBoundary(solid, sheets, facets_of[t]);
  });
  std::vector<Facet> facets;
  for (const std::vector<Facet>& some : facets_of)
    facets.insert(facets.end(), some.begin(), some.end());
  return facets;
}

}  // namespace

double CoincidenceTolerance(const TriangleMesh& mesh) {
  return 1e-6 * BoundsOf(mesh).size().norm();
}

TriangleMesh WithBodiesTurnedOut(const TriangleMesh& mesh) {
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
  // a cavity lies in some other body, a body turned inside out does not: asked of three of its
  // corners
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
  return PiecesOf(mesh, solid, false);
}

std::vector<Facet> UnionBoundaryAndSheets(const TriangleMesh& mesh,
                                          const std::function<bool(const Vec3&)>& solid) {
  return PiecesOf(mesh, solid, true);
}

}  // namespace tandem
