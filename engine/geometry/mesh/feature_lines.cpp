#include "engine/geometry/mesh/feature_lines.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace tandem {

FeatureLines::FeatureLines(const TriangleMesh& mesh, HugeVector<Edge> edges)
    : mesh_(mesh), edges_(std::move(edges)), first_(mesh.vertices.size() + 1, 0) {
  for (const Edge& e : edges_) {
    for (const std::uint32_t v : e.ends) ++first_[v + 1];
  }
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  at_.resize(first_.back());
  HugeVector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t e = 0; e < edges_.size(); ++e) {
    for (const std::uint32_t v : edges_[e].ends) at_[next[v]++] = e;
  }
}

std::vector<std::uint32_t> FeatureLines::FindVertices(double tolerance) {
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
  // the rest are closed lines
  for (std::uint32_t e = 0; e < edges_.size(); ++e) Walk(edges_[e].ends[0], e, ends, tolerance);
  std::vector<std::uint32_t> vertices;
  for (std::uint32_t v = 0; v < corner_.size(); ++v) {
    if (corner_[v] != 0) vertices.push_back(v);
  }
  return vertices;
}

void FeatureLines::Walk(std::uint32_t start, std::uint32_t edge,
                        const std::vector<std::uint8_t>& ends, double tolerance) {
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

bool FeatureLines::LeavesChord(std::size_t from, std::size_t to, double tolerance) const {
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

}  // namespace tandem
