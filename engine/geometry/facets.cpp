#include "engine/geometry/facets.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>

namespace tandem {

namespace {

constexpr std::uint32_t kNone = MeshSides::kNone;

/// Grows one polygon at a time.
class Grower {
 public:
  Grower(const TriangleMesh& mesh, const MeshSides& sides, double tolerance)
      : mesh_(mesh), sides_(sides), tolerance_(tolerance) {
    const std::size_t count = mesh.triangles.size();
    areas_.reserve(count);
    for (std::size_t t = 0; t < count; ++t) {
      areas_.push_back(
          (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)));
    }
    polygon_of_.assign(count, kNone);
    tried_by_.assign(count, kNone);
    holds_.assign(mesh.vertices.size(), kNone);
  }

  /// The polygon of each triangle.
  std::vector<std::uint32_t> Grow() {
    std::vector<std::uint32_t> seeds(areas_.size());
    std::iota(seeds.begin(), seeds.end(), 0U);
    std::vector<double> sizes;
    sizes.reserve(areas_.size());
    for (const Vec3& area : areas_) sizes.push_back(area.squaredNorm());
    std::stable_sort(seeds.begin(), seeds.end(), [&](std::uint32_t a, std::uint32_t b) {
      return sizes[a] > sizes[b];
    });
    for (const std::uint32_t seed : seeds) {
      if (polygon_of_[seed] == kNone) GrowFrom(seed);
    }
    return std::move(polygon_of_);
  }
  std::uint32_t polygons() const { return polygons_; }

 private:
  struct Candidate {
    double turn;  // 1 - cos of the angle to the polygon's normal when it was met
    std::uint32_t triangle;
    bool operator<(const Candidate& o) const {  // the queue gives the greatest first
      return turn != o.turn ? turn > o.turn : triangle > o.triangle;
    }
  };

  void GrowFrom(std::uint32_t seed) {
    area_ = Vec3::Zero();
    moment_ = Vec3::Zero();
    weight_ = 0;
    vertices_.clear();
    least_cosine_ = 1;
    while (!queue_.empty()) queue_.pop();
    Join(seed, areas_[seed], Moment(seed), Normal(areas_[seed]));
    while (!queue_.empty()) {
      const std::uint32_t triangle = queue_.top().triangle;
      queue_.pop();
      if (polygon_of_[triangle] == kNone) TryToJoin(triangle);
    }
    ++polygons_;
  }

  static Vec3 Normal(const Vec3& area) {
    const double norm = area.norm();
    return norm > 0 ? Vec3(area / norm) : Vec3::Zero();
  }
  /// Centre times area, so that the mean plane goes through the centre of the polygon's area.
  Vec3 Moment(std::uint32_t t) const {
    return areas_[t].norm() / 3.0 * (mesh_.corner(t, 0) + mesh_.corner(t, 1) + mesh_.corner(t, 2));
  }

  void TryToJoin(std::uint32_t triangle) {
    const Vec3 area = area_ + areas_[triangle];
    const Vec3 moment = moment_ + Moment(triangle);
    const double weight = weight_ + areas_[triangle].norm();
    const Vec3 n = Normal(area);
    const Vec3 centre = weight > 0 ? Vec3(moment / weight) : mesh_.corner(triangle, 0);
    if (areas_[triangle].norm() > 0 && !(areas_[triangle].dot(n) > 0)) return;
    for (std::size_t k = 0; k < 3; ++k) {
      if (std::abs((mesh_.corner(triangle, k) - centre).dot(n)) > tolerance_) return;
    }
    if (!StillFlat(n, centre)) return;
    Join(triangle, area, moment, n);
  }

  /// Whether all vertices so far lie within tolerance of the new plane, and all triangles face with
  /// it. What was last found by looking at them all tells, while the plane has hardly moved.
  bool StillFlat(const Vec3& n, const Vec3& centre) {
    const double turn = (n - n_).norm();
    const double shift = std::abs((centre - centre_).dot(n));
    const double reach = reach_ + (centre - centre_).norm();
    if (height_ + shift + turn * reach <= tolerance_ && least_cosine_ - turn > 0) return true;
    double height = 0;
    reach_ = 0;
    for (const std::uint32_t v : vertices_) {
      height = std::max(height, std::abs((mesh_.vertices[v] - centre).dot(n)));
      reach_ = std::max(reach_, (mesh_.vertices[v] - centre).norm());
    }
    double least = 1;
    for (const std::uint32_t t : members_) {
      const double norm = areas_[t].norm();
      if (norm > 0) least = std::min(least, areas_[t].dot(n) / norm);
    }
    n_ = n;
    centre_ = centre;
    height_ = height;
    least_cosine_ = least;
    return height <= tolerance_ && least > 0;
  }

  void Join(std::uint32_t triangle, const Vec3& area, const Vec3& moment, const Vec3& n) {
    if (weight_ == 0) {  // the first
      members_.clear();
      n_ = n;
      centre_ = mesh_.corner(triangle, 0);
      height_ = 0;
      reach_ = 0;
    }
    area_ = area;
    moment_ = moment;
    weight_ += areas_[triangle].norm();
    polygon_of_[triangle] = polygons_;
    members_.push_back(triangle);
    const double norm = areas_[triangle].norm();
    if (norm > 0) least_cosine_ = std::min(least_cosine_, areas_[triangle].dot(n_) / norm);
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t v = mesh_.triangles[triangle][k];
      if (holds_[v] != polygons_) {
        holds_[v] = polygons_;
        vertices_.push_back(v);
        height_ = std::max(height_, std::abs((mesh_.vertices[v] - centre_).dot(n_)));
        reach_ = std::max(reach_, (mesh_.vertices[v] - centre_).norm());
      }
      const std::uint32_t other = sides_.Across(triangle, k);
      if (other == kNone || polygon_of_[other] != kNone || tried_by_[other] == polygons_) continue;
      tried_by_[other] = polygons_;
      const double other_norm = areas_[other].norm();
      const double turn = other_norm > 0 ? 1.0 - areas_[other].dot(n) / other_norm : 0.0;
      if (turn < 1.0) queue_.push({turn, other});
    }
  }

  const TriangleMesh& mesh_;
  const MeshSides& sides_;
  double tolerance_;
  std::vector<Vec3> areas_;  // twice the area, along the normal
  std::vector<std::uint32_t> polygon_of_;
  std::vector<std::uint32_t> tried_by_;  // the last polygon that met the triangle
  std::vector<std::uint32_t> holds_;     // per vertex: the last polygon that has it
  std::uint32_t polygons_ = 0;

  // the polygon that grows
  Vec3 area_ = Vec3::Zero();
  Vec3 moment_ = Vec3::Zero();
  double weight_ = 0;
  std::vector<std::uint32_t> vertices_;
  std::vector<std::uint32_t> members_;
  std::priority_queue<Candidate> queue_;
  // found by looking at all of it, and bounds since: of a plane with normal n_ through centre_
  Vec3 n_ = Vec3::Zero();
  Vec3 centre_ = Vec3::Zero();
  double height_ = 0;
  double reach_ = 0;
  double least_cosine_ = 1;
};

/// The lines of feature edges, and where vertices stand on them.
class FeatureLines {
 public:
  struct Edge {
    std::array<std::uint32_t, 2> ends;
    std::array<std::uint32_t, 2> polygons;  // on its two sides; equal for a wall within nothing
  };

  FeatureLines(const TriangleMesh& mesh, std::vector<Edge> edges)
      : mesh_(mesh), edges_(std::move(edges)), first_(mesh.vertices.size() + 1, 0) {
    for (const Edge& e : edges_) {
      for (const std::uint32_t v : e.ends) ++first_[v + 1];
    }
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    at_.resize(first_.back());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t e = 0; e < edges_.size(); ++e) {
      for (const std::uint32_t v : edges_[e].ends) at_[next[v]++] = e;
    }
  }

  std::vector<std::uint32_t> FindVertices(double tolerance) {
    corner_.assign(mesh_.vertices.size(), 0);
    for (std::uint32_t v = 0; v < corner_.size(); ++v) {
      const std::uint32_t count = first_[v + 1] - first_[v];
      corner_[v] = count != 0 && (count != 2 || edges_[at_[first_[v]]].polygons !=
                                                    edges_[at_[first_[v] + 1]].polygons);
    }
    walked_.assign(edges_.size(), 0);
    const std::vector<std::uint8_t> ends = corner_;
    for (std::uint32_t v = 0; v < corner_.size(); ++v) {
      if (ends[v] == 0) continue;
      for (std::uint32_t i = first_[v]; i < first_[v + 1]; ++i) Walk(v, at_[i], ends, tolerance);
    }
    // what is left are closed lines
    for (std::uint32_t e = 0; e < edges_.size(); ++e) Walk(edges_[e].ends[0], e, ends, tolerance);
    std::vector<std::uint32_t> vertices;
    for (std::uint32_t v = 0; v < corner_.size(); ++v) {
      if (corner_[v] != 0) vertices.push_back(v);
    }
    return vertices;
  }

 private:
  /// Follows a line from a vertex by an edge to its end, and marks where it leaves its chord.
  void Walk(std::uint32_t start, std::uint32_t edge, const std::vector<std::uint8_t>& ends,
            double tolerance) {
    if (walked_[edge] != 0) return;
    run_.assign(1, start);
    std::uint32_t v = start;
    while (walked_[edge] == 0) {
      walked_[edge] = 1;
      v = edges_[edge].ends[edges_[edge].ends[0] == v ? 1 : 0];
      run_.push_back(v);
      if (ends[v] != 0) break;
      const std::uint32_t one = at_[first_[v]];
      edge = one == edge ? at_[first_[v] + 1] : one;
    }
    const bool closed = v == start && ends[start] == 0;
    std::size_t from = 0;
    std::size_t marked = 0;
    for (std::size_t to = 2; to < run_.size(); ++to) {
      if (!LeavesChord(from, to, tolerance)) continue;
      from = to - 1;
      corner_[run_[from]] = 1;
      ++marked;
    }
    if (closed && marked > 0) corner_[start] = 1;
  }

  bool LeavesChord(std::size_t from, std::size_t to, double tolerance) const {
    const Vec3& a = mesh_.vertices[run_[from]];
    const Vec3 along = mesh_.vertices[run_[to]] - a;
    const double square = along.squaredNorm();
    for (std::size_t i = from + 1; i < to; ++i) {
      const Vec3 p = mesh_.vertices[run_[i]] - a;
      const double t = square > 0 ? std::clamp(p.dot(along) / square, 0.0, 1.0) : 0.0;
      if ((p - t * along).squaredNorm() > tolerance * tolerance) return true;
    }
    return false;
  }

  const TriangleMesh& mesh_;
  std::vector<Edge> edges_;
  std::vector<std::uint32_t> first_;  // per vertex: into at_
  std::vector<std::uint32_t> at_;     // edges
  std::vector<std::uint8_t> corner_;
  std::vector<std::uint8_t> walked_;
  std::vector<std::uint32_t> run_;
};

}  // namespace

Features FindFeatures(const TriangleMesh& mesh, double tolerance) {
  return FindFeatures(mesh, MeshSides(mesh), tolerance);
}

Features FindFeatures(const TriangleMesh& mesh, const MeshSides& sides, double tolerance) {
  Grower grower(mesh, sides, tolerance);
  Features features;
  features.polygon_of = grower.Grow();
  features.polygons = grower.polygons();

  std::vector<FeatureLines::Edge> edges;
  for (const MeshSides::Wall& wall : sides.walls()) edges.push_back({wall.ends, {kNone, kNone}});
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t other = sides.Across(t, k);
      if (other == kNone || other < t) continue;
      const std::uint32_t one = features.polygon_of[t];
      const std::uint32_t two = features.polygon_of[other];
      if (one == two) continue;
      const std::uint32_t a = mesh.triangles[t][k];
      const std::uint32_t b = mesh.triangles[t][(k + 1) % 3];
      edges.push_back({{std::min(a, b), std::max(a, b)}, {std::min(one, two), std::max(one, two)}});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const auto& a, const auto& b) {
    return a.ends < b.ends;
  });
  features.edges.reserve(edges.size());
  for (const FeatureLines::Edge& e : edges) features.edges.push_back(e.ends);
  features.vertices = FeatureLines(mesh, std::move(edges)).FindVertices(tolerance);
  return features;
}

FeatureNormals FindFeatureNormals(const TriangleMesh& mesh, const Features& features) {
  FeatureNormals normals;
  normals.edges.assign(features.edges.size(), Vec3::Zero());
  normals.vertices.assign(features.vertices.size(), Vec3::Zero());
  std::vector<std::uint32_t> feature_of(mesh.vertices.size(), kNone);
  std::vector<std::uint8_t> on_edge(mesh.vertices.size(), 0);
  for (std::uint32_t i = 0; i < features.vertices.size(); ++i) feature_of[features.vertices[i]] = i;
  for (const auto& [a, b] : features.edges) on_edge[a] = on_edge[b] = 1;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const TriangleMesh::Triangle& corners = mesh.triangles[t];
    const Vec3 area =
        (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0));
    if (!(area.norm() > 0)) continue;
    const Vec3 n = area.normalized();
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = corners[k];
      const std::uint32_t b = corners[(k + 1) % 3];
      if (feature_of[a] != kNone) {
        const Vec3 one = (mesh.vertices[b] - mesh.vertices[a]).normalized();
        const Vec3 two = (mesh.corner(t, (k + 2) % 3) - mesh.vertices[a]).normalized();
        normals.vertices[feature_of[a]] += std::acos(std::clamp(one.dot(two), -1.0, 1.0)) * n;
      }
      if (on_edge[a] == 0 || on_edge[b] == 0) continue;
      const std::array<std::uint32_t, 2> ends{std::min(a, b), std::max(a, b)};
      const auto found = std::lower_bound(features.edges.begin(), features.edges.end(), ends);
      if (found != features.edges.end() && *found == ends) {
        normals.edges[static_cast<std::size_t>(found - features.edges.begin())] += n;
      }
    }
  }
  for (Vec3& n : normals.edges) n.normalize();
  for (Vec3& n : normals.vertices) n.normalize();
  return normals;
}

}  // namespace tandem
