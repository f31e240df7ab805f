#include "engine/geometry/exact/mesh_tree.h"

#include <utility>

#include "engine/geometry/exact/tree_pair.h"
#include "engine/geometry/mesh/closest_on_triangle.h"

namespace tandem {
namespace {

constexpr std::uint32_t kLeafSize = 2;
using Triangle = std::array<Vec3, 3>;

struct PointPair {
  Vec3 a, b;
};

Vec3 ClosestOn(const Triangle& t, const Vec3& p) {
  return ClosestOnTriangle(t[0], t[1], t[2], p).point;
}

/// Returns the closest points of two segments; Ericson 5.1.9.
PointPair ClosestOfSegments(const Vec3& p, const Vec3& p_end, const Vec3& q, const Vec3& q_end) {
  const Vec3 along_p = p_end - p;
  const Vec3 along_q = q_end - q;
  const Vec3 r = p - q;
  const double a = along_p.squaredNorm();
  const double e = along_q.squaredNorm();
  const double f = along_q.dot(r);
  double s = 0;
  double t = 0;
  if (a <= 0) {
    t = e <= 0 ? 0 : std::clamp(f / e, 0.0, 1.0);
  } else {
    const double c = along_p.dot(r);
    if (e <= 0) {
      s = std::clamp(-c / a, 0.0, 1.0);
    } else {
      const double b = along_p.dot(along_q);
      const double denominator = a * e - b * b;
      if (denominator > 0) s = std::clamp((b * f - c * e) / denominator, 0.0, 1.0);
      t = (b * s + f) / e;
      if (t < 0) {
        t = 0;
        s = std::clamp(-c / a, 0.0, 1.0);
      } else if (t > 1) {
        t = 1;
        s = std::clamp((b - c) / a, 0.0, 1.0);
      }
    }
  }
  return {p + s * along_p, q + t * along_q};
}

/// Finds where a segment goes through a triangle's plane; returns whether that is within the
/// triangle.
bool Crosses(const Vec3& from, const Vec3& to, const Triangle& t, Vec3& at) {
  const Vec3 n = (t[1] - t[0]).cross(t[2] - t[0]);
  const double above = n.dot(from - t[0]);
  const double below = n.dot(to - t[0]);
  if (above * below >= 0) return false;  // other tests detect touching
  at = from + (above / (above - below)) * (to - from);
  for (std::size_t k = 0; k < 3; ++k) {
    if (n.dot((t[(k + 1) % 3] - t[k]).cross(at - t[k])) < 0) return false;
  }
  return true;
}

class Search {
 public:
  Search(const MeshTree& a, const Pose& X_BA, const MeshTree& b,
         const ClosestPointsOptions& options)
      : a_(a), b_(b), X_BA_(X_BA), options_(options) {}

  ClosestPoints Run() {
    const double left_out = VisitNearPairs(
        a_.tree, b_.tree,
        [this](const BoxTree::Node& node_a, const BoxTree::Node& node_b) {
          ++pairs_;
          return Least(node_a, node_b);
        },
        [this] {
          const bool over = best_.distance <= 0 || pairs_ >= options_.most_pairs;
          return over ? -1.0 : std::min(options_.at_most, best_.distance - options_.tolerance);
        },
        [this](const BoxTree::Node& leaf_a, const BoxTree::Node& leaf_b) {
          TestLeaves(leaf_a, leaf_b);
        });
    best_.least = std::max(0.0, std::min(best_.distance, left_out));
    return best_;
  }

 private:
  /// Bounds the distance of two nodes from below. The box of a large slanting triangle is a loose
  /// bound. So for a leaf it also takes the distance of its own triangles from the ball round the
  /// other box.
  double Least(const BoxTree::Node& node_a, const BoxTree::Node& node_b) const {
    double least = X_BA_.Least(node_a.box, node_b.box);
    if (node_b.leaf()) {
      const Vec3 centre = X_BA_.R * node_a.box.centre() + X_BA_.p;
      least = std::max(least, ToTriangles(b_, node_b, centre) - 0.5 * node_a.box.size().norm());
    }
    if (node_a.leaf()) {
      const Vec3 centre = X_BA_.R.transpose() * (node_b.box.centre() - X_BA_.p);
      least = std::max(least, ToTriangles(a_, node_a, centre) - 0.5 * node_b.box.size().norm());
    }
    return least;
  }

  static double ToTriangles(const MeshTree& mesh, const BoxTree::Node& leaf, const Vec3& p) {
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t i = leaf.first; i < leaf.first + leaf.count; ++i) {
      least = std::min(least, (ClosestOn(mesh.triangles[i], p) - p).norm());
    }
    return least;
  }

  void TestLeaves(const BoxTree::Node& node_a, const BoxTree::Node& node_b) {
    for (std::uint32_t i = node_a.first; i < node_a.first + node_a.count; ++i) {
      Triangle t;
      for (std::size_t k = 0; k < 3; ++k) t[k] = X_BA_.R * a_.triangles[i][k] + X_BA_.p;
      for (std::uint32_t j = node_b.first; j < node_b.first + node_b.count; ++j) {
        ++pairs_;
        TestTriangles(t, b_.triangles[j]);
      }
    }
  }

  void TestTriangles(const Triangle& t, const Triangle& u) {
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        Offer(ClosestOfSegments(t[i], t[(i + 1) % 3], u[j], u[(j + 1) % 3]));
      }
      Offer({t[i], ClosestOn(u, t[i])});
      Offer({ClosestOn(t, u[i]), u[i]});
      Vec3 at;
      if (Crosses(t[i], t[(i + 1) % 3], u, at) || Crosses(u[i], u[(i + 1) % 3], t, at)) {
        Offer({at, at});
      }
    }
  }

  void Offer(const PointPair& pair) {
    const double distance = (pair.a - pair.b).norm();
    if (!(distance < best_.distance)) return;
    best_.distance = distance;
    best_.p_BA = pair.a;
    best_.p_BB = pair.b;
  }

  const MeshTree& a_;
  const MeshTree& b_;
  RotatedFrame X_BA_;
  const ClosestPointsOptions& options_;
  std::size_t pairs_ = 0;
  ClosestPoints best_;
};

}  // namespace

MeshTree::MeshTree(const TriangleMesh& mesh) {
  std::vector<Bounds> boxes(mesh.triangles.size());
  for (std::size_t t = 0; t < boxes.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) boxes[t].Add(mesh.corner(t, k));
  }
  tree = BuildBoxTree(boxes, kLeafSize);
  triangles.reserve(boxes.size());
  for (const std::uint32_t t : tree.order) {
    triangles.push_back({mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)});
  }
}

ClosestPoints FindClosestPoints(const MeshTree& a, const Pose& X_BA, const MeshTree& b,
                                const ClosestPointsOptions& options) noexcept {
  return Search(a, X_BA, b, options).Run();
}

}  // namespace tandem
