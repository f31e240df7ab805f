#include "engine/geometry/mesh/mesh_diagnosis.h"

#include <algorithm>
#include <numeric>
#include <span>
#include <vector>

namespace tandem {
namespace {

constexpr double kFlatness = 1e-8;  // height over longest side

/// Disjoint sets of vertices.
class Components {
 public:
  explicit Components(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0U);
  }
  std::uint32_t Find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void Join(std::uint32_t i, std::uint32_t j) {
    i = Find(i);
    j = Find(j);
    parent_[std::max(i, j)] = std::min(i, j);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

/// Tells whether a triangle has fewer than three different vertices: it is a line or a point, and
/// has no edges that could be open.
bool Collapsed(const TriangleMesh::Triangle& t) {
  return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

/// Tells whether a triangle is so thin that its normal is rounding noise of single-precision
/// coordinates.
bool Flat(const TriangleMesh& mesh, std::size_t t) {
  const Vec3& a = mesh.corner(t, 0);
  const Vec3& b = mesh.corner(t, 1);
  const Vec3& c = mesh.corner(t, 2);
  const double longest_squared =
      std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
  return (b - a).cross(c - a).norm() <= kFlatness * longest_squared;
}

void CountBodies(const TriangleMesh& mesh, MeshDiagnosis& diagnosis) {
  Components components(mesh.vertices.size());
  for (const TriangleMesh::Triangle& t : mesh.triangles) {
    components.Join(t[0], t[1]);
    components.Join(t[0], t[2]);
  }
  constexpr std::uint32_t kUnnumbered = ~0U;
  std::vector<std::uint32_t> number(mesh.vertices.size(), kUnnumbered);
  diagnosis.body_of_triangle.reserve(mesh.triangles.size());
  for (const TriangleMesh::Triangle& t : mesh.triangles) {
    std::uint32_t& body = number[components.Find(t[0])];
    if (body == kUnnumbered) body = static_cast<std::uint32_t>(diagnosis.bodies++);
    diagnosis.body_of_triangle.push_back(body);
  }
}

/// Calls `use` with each edge of each triangle: its lesser vertex, its greater one, and whether the
/// triangle runs it upwards.
template <typename Use>
void ForEachEdge(const TriangleMesh& mesh, const Use& use) {
  for (const TriangleMesh::Triangle& t : mesh.triangles) {
    if (Collapsed(t)) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t from = t[k];
      const std::uint32_t to = t[(k + 1) % 3];
      use(std::min(from, to), std::max(from, to), from < to);
    }
  }
}

/// Counts the faults among all uses of the edges that have one lesser vertex: twice the greater
/// vertex of each, and one more where a triangle runs it upwards.
void CountEdgesOfVertex(std::span<std::uint64_t> uses, MeshDiagnosis& diagnosis) {
  std::sort(uses.begin(), uses.end());
  for (std::size_t i = 0; i < uses.size();) {
    std::size_t end = i + 1;
    while (end < uses.size() && uses[end] / 2 == uses[i] / 2) ++end;
    if (end - i == 1) ++diagnosis.open_edges;
    if (end - i == 2 && uses[i] == uses[i + 1]) ++diagnosis.flipped_edges;
    if (end - i > 2) ++diagnosis.non_manifold_edges;
    i = end;
  }
}

/// Collects the edges by their lesser vertex, at which only a few edges begin: sorting all edges of
/// a large mesh at once takes several times as long.
void CountEdges(const TriangleMesh& mesh, MeshDiagnosis& diagnosis) {
  const std::size_t vertices = mesh.vertices.size();
  // by vertex: start of its uses; one place further on during the count
  std::vector<std::size_t> begin(vertices + 2, 0);
  ForEachEdge(mesh, [&](std::uint32_t lesser, std::uint32_t, bool) {
    ++begin[lesser + 2];
  });
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<std::uint64_t> uses(begin.back());
  ForEachEdge(mesh, [&](std::uint32_t lesser, std::uint32_t greater, bool upwards) {
    uses[begin[lesser + 1]++] = 2 * std::uint64_t{greater} + (upwards ? 1U : 0U);
  });
  for (std::size_t v = 0; v < vertices; ++v) {
    CountEdgesOfVertex(std::span(uses).subspan(begin[v], begin[v + 1] - begin[v]), diagnosis);
  }
}

std::string Count(std::size_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

}  // namespace

MeshDiagnosis Diagnose(const TriangleMesh& mesh) {
  MeshDiagnosis diagnosis;
  CountBodies(mesh, diagnosis);
  CountEdges(mesh, diagnosis);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    diagnosis.flat_triangles += Flat(mesh, t) ? 1U : 0U;
  }
  return diagnosis;
}

std::string Describe(const MeshDiagnosis& d) {
  std::string line = d.closed() ? "closed" : "";
  const auto add = [&line](std::size_t count, const char* one, const char* many) {
    if (count == 0) return;
    if (!line.empty()) line += ", ";
    line += Count(count, one, many);
  };
  add(d.open_edges, "open edge", "open edges");
  add(d.non_manifold_edges, "non-manifold edge", "non-manifold edges");
  add(d.flipped_edges, "flipped edge", "flipped edges");
  add(d.flat_triangles, "flat triangle", "flat triangles");
  const bool faultless = d.closed() && d.flat_triangles == 0;
  return line + (faultless ? ", " : "; ") + Count(d.bodies, "body", "bodies");
}

}  // namespace tandem
