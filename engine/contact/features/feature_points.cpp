#include "engine/contact/features/feature_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>

#include "engine/contact/features/crown_points.h"
#include "engine/geometry/mesh/feature_normals.h"

namespace tandem {

namespace {

/// Walks along the lines that feature edges make, from vertex to vertex.
class FeatureLineWalk {
 public:
  FeatureLineWalk(const TriangleMesh& mesh_W, const Features& features, double voxel_size,
                  double spacing)
      : mesh_(mesh_W),
        features_(features),
        normals_(FindFeatureNormals(mesh_W, features)),
        voxel_size_(voxel_size),
        spacing_(spacing),
        first_(mesh_W.vertices.size() + 1, 0),
        walked_(features.edges.size(), 0),
        is_vertex_(mesh_W.vertices.size(), 0) {
    for (const auto& ends : features.edges) {
      for (const std::uint32_t v : ends) ++first_[v + 1];
    }
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    at_.resize(first_.back());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t e = 0; e < features.edges.size(); ++e) {
      for (const std::uint32_t v : features.edges[e]) at_[next[v]++] = e;
    }
    for (const std::uint32_t v : features.vertices) is_vertex_[v] = 1;
  }

  std::vector<FeaturePoint> Find() {
    AddVertices();
    for (const std::uint32_t v : features_.vertices) {
      for (const std::uint32_t e : EdgesAt(v)) Walk(v, e);
    }
    // the rest are closed lines
    for (std::uint32_t e = 0; e < features_.edges.size(); ++e) Walk(features_.edges[e][0], e);
    return std::move(points_);
  }

 private:
  std::span<const std::uint32_t> EdgesAt(std::uint32_t vertex) const {
    return std::span(at_).subspan(first_[vertex], first_[vertex + 1] - first_[vertex]);
  }
  bool Bulges(std::uint32_t edge) const {
    return normals_.edge_cosines[edge] >= 0 && normals_.edges[edge].squaredNorm() > 0;
  }
  Vec3 PlaceOf(std::uint32_t vertex) const { return mesh_.vertices[vertex] / voxel_size_; }

  void AddVertices() {
    for (std::size_t i = 0; i < features_.vertices.size(); ++i) {
      const std::uint32_t v = features_.vertices[i];
      const auto edges = EdgesAt(v);
      const bool leans = std::any_of(edges.begin(), edges.end(), [this](std::uint32_t e) {
        return Bulges(e);
      });
      const Vec3& outward = normals_.vertices[i];
      if (leans && outward.squaredNorm() > 0) {
        points_.push_back({.place_W = PlaceOf(v), .outward = outward});
      }
    }
  }

  /// Follows a line from a vertex to the next and cuts the parts of it that bulge.
  void Walk(std::uint32_t start, std::uint32_t edge) {
    if (walked_[edge] != 0) return;
    run_.clear();
    std::uint32_t v = start;
    bool from_vertex = is_vertex_[start] != 0;
    while (walked_[edge] == 0) {
      walked_[edge] = 1;
      const auto& ends = features_.edges[edge];
      const std::uint32_t to = ends[ends[0] == v ? 1 : 0];
      if (Bulges(edge)) {
        run_.push_back({edge, PlaceOf(v), PlaceOf(to)});
      } else {
        CutRun(from_vertex, false);
        from_vertex = false;
      }
      v = to;
      if (is_vertex_[v] != 0) break;
      const auto next = EdgesAt(v);
      edge = next[next[0] == edge && next.size() > 1 ? 1 : 0];
    }
    CutRun(from_vertex, is_vertex_[v] != 0);
  }

  struct Step {
    std::uint32_t edge;
    Vec3 from;
    Vec3 to;
    double length() const { return (to - from).norm(); }
  };

  /// Cuts the steps of the run into parts of equal length. `begins`, `ends`: the run does so at a
  /// vertex.
  void CutRun(bool begins, bool ends) {
    double length = 0;
    for (const Step& step : run_) length += step.length();
    if (length > 0) {
      // a part ends at one vertex at most
      const double least = begins && ends ? 2 : 1;
      const auto count = static_cast<std::size_t>(std::max(least, std::ceil(length / spacing_)));
      std::size_t at = 0;
      double before = 0;  // length of the run up to the step
      Vec3 from = run_.front().from;
      for (std::size_t k = 0; k < count; ++k) {
        const double until = length * static_cast<double>(k + 1) / static_cast<double>(count);
        FeaturePoint part = PartUntil(until, from, at, before);
        if (k == 0 && begins) {
          part.ends = true;
        } else if (k + 1 == count && ends) {
          part.ends = true;
          part.tangent = -part.tangent;
        }
        if (part.is_edge()) points_.push_back(part);
      }
    }
    run_.clear();
  }

  /// Returns the part from `from` to a length `until` of the run, and moves `from` to its end.
  /// Begins at step `at`, which starts `before` along the run.
  FeaturePoint PartUntil(double until, Vec3& from, std::size_t& at, double& before) {
    const Vec3 begin = from;
    FeaturePoint part;
    double longest = 0;
    for (;;) {
      const Step& step = run_[at];
      const bool last = at + 1 == run_.size();
      const double whole = step.length();
      const bool passes = !last && before + whole <= until;
      const double along = whole > 0 ? std::clamp((until - before) / whole, 0.0, 1.0) : 0.0;
      const Vec3 end = passes ? step.to : Vec3(step.from + along * (step.to - step.from));
      const double here = (end - from).norm();
      part.outward += here * normals_.edges[step.edge];
      if (here > longest) {
        longest = here;
        part.cosine = normals_.edge_cosines[step.edge];
      }
      from = end;
      if (!passes) break;
      before += whole;
      ++at;
    }
    const Vec3 chord = from - begin;
    part.half_length = 0.5 * chord.norm();
    if (part.half_length > 0) part.tangent = chord.normalized();
    part.place_W = begin + 0.5 * chord;
    if (part.outward.squaredNorm() > 0) part.outward.normalize();
    return part;
  }

  const TriangleMesh& mesh_;
  const Features& features_;
  const FeatureNormals normals_;
  double voxel_size_;
  double spacing_;
  std::vector<std::uint32_t> first_;  // per mesh vertex: index into at_
  std::vector<std::uint32_t> at_;     // feature edges
  std::vector<std::uint8_t> walked_;  // per feature edge
  std::vector<std::uint8_t> is_vertex_;
  std::vector<Step> run_;
  std::vector<FeaturePoint> points_;
};

}  // namespace

std::vector<FeaturePoint> FindFeaturePoints(const TriangleMesh& mesh_W, const Features& features,
                                            double voxel_size, double spacing) {
  std::vector<FeaturePoint> points = FeatureLineWalk(mesh_W, features, voxel_size, spacing).Find();
  AddCrownPoints(mesh_W, MeshSides(mesh_W), voxel_size, points);
  return points;
}

}  // namespace tandem
