#include "app/view/model/scene/shaded_mesh.h"

#include <algorithm>

namespace tandem {

namespace {

/// The triangles round each vertex: those of vertex v are at [first[v], first[v + 1]).
struct Fans {
  std::vector<std::uint32_t> first;
  std::vector<std::uint32_t> triangle;
};

Fans FansOf(const TriangleMesh& mesh, const std::vector<Vec3>& normals) {
  Fans fans;
  fans.first.assign(mesh.vertices.size() + 1, 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (normals[t].isZero()) continue;
    for (const std::uint32_t v : mesh.triangles[t]) ++fans.first[v + 1];
  }
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) fans.first[v + 1] += fans.first[v];
  fans.triangle.resize(fans.first.back());
  std::vector<std::uint32_t> next(fans.first.begin(), fans.first.end() - 1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (normals[t].isZero()) continue;
    for (const std::uint32_t v : mesh.triangles[t]) {
      fans.triangle[next[v]++] = static_cast<std::uint32_t>(t);
    }
  }
  return fans;
}

/// Returns the triangle's angle at its corner k. As a weight it makes normals independent of the
/// triangulation.
double CornerAngle(const TriangleMesh& mesh, std::size_t t, std::size_t k) {
  const Vec3 a = mesh.corner(t, (k + 1) % 3) - mesh.corner(t, k);
  const Vec3 b = mesh.corner(t, (k + 2) % 3) - mesh.corner(t, k);
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

std::size_t CornerOf(const TriangleMesh::Triangle& triangle, std::uint32_t vertex) {
  return static_cast<std::size_t>(std::find(triangle.begin(), triangle.end(), vertex) -
                                  triangle.begin());
}

ShadedMesh::Vertex ToVertex(const Vec3& p, const Vec3& n) {
  const Eigen::Vector3f pf = p.cast<float>();
  const Eigen::Vector3f nf = n.cast<float>();
  return {{pf.x(), pf.y(), pf.z()}, {nf.x(), nf.y(), nf.z()}};
}

/// The use of an edge by a triangle.
struct EdgeUse {
  std::uint32_t low, high;  // vertices of the welded mesh
  std::uint32_t triangle;
  std::uint32_t shaded_low, shaded_high;
};

}  // namespace

ShadedMesh Shade(const TriangleMesh& mesh, double crease_angle) {
  std::vector<Vec3> normals(mesh.triangles.size(), Vec3::Zero());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 n =
        (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0));
    const double twice_area = n.norm();
    if (twice_area > 0) normals[t] = n / twice_area;
  }
  const Fans fans = FansOf(mesh, normals);
  const double crease_cosine = std::cos(crease_angle);

  ShadedMesh shaded;
  std::vector<std::array<std::uint32_t, 3>> shaded_corners(mesh.triangles.size());
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    const std::size_t sides_begin = shaded.vertices.size();
    for (std::uint32_t i = fans.first[v]; i < fans.first[v + 1]; ++i) {
      const std::uint32_t t = fans.triangle[i];
      Vec3 sum = Vec3::Zero();
      for (std::uint32_t j = fans.first[v]; j < fans.first[v + 1]; ++j) {
        const std::uint32_t u = fans.triangle[j];
        if (normals[t].dot(normals[u]) < crease_cosine) continue;
        sum += CornerAngle(mesh, u, CornerOf(mesh.triangles[u], v)) * normals[u];
      }
      const ShadedMesh::Vertex corner =
          ToVertex(mesh.vertices[v], sum.isZero() ? normals[t] : Vec3(sum.normalized()));
      // triangles of one smooth side share a vertex
      std::size_t side = sides_begin;
      const Eigen::Map<const Eigen::Vector3f> n(corner.n.data());
      while (side < shaded.vertices.size() &&
             Eigen::Map<const Eigen::Vector3f>(shaded.vertices[side].n.data()).dot(n) < 0.9999F) {
        ++side;
      }
      if (side == shaded.vertices.size()) shaded.vertices.push_back(corner);
      shaded_corners[t].at(CornerOf(mesh.triangles[t], v)) = static_cast<std::uint32_t>(side);
    }
  }

  std::vector<EdgeUse> uses;
  uses.reserve(3 * mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (normals[t].isZero()) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      shaded.triangles.push_back(shaded_corners[t].at(k));
      EdgeUse use{mesh.triangles[t].at(k), mesh.triangles[t].at((k + 1) % 3), t,
                  shaded_corners[t].at(k), shaded_corners[t].at((k + 1) % 3)};
      if (use.low > use.high) {
        std::swap(use.low, use.high);
        std::swap(use.shaded_low, use.shaded_high);
      }
      uses.push_back(use);
    }
  }
  std::sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) {
    return a.low != b.low ? a.low < b.low : a.high < b.high;
  });
  for (std::size_t begin = 0, end = 0; begin < uses.size(); begin = end) {
    const EdgeUse& first = uses[begin];
    for (end = begin; end < uses.size(); ++end) {
      if (uses[end].low != first.low || uses[end].high != first.high) break;
    }
    const bool smooth = end - begin == 2 && normals[first.triangle].dot(
                                                normals[uses[begin + 1].triangle]) >= crease_cosine;
    if (smooth) continue;
    shaded.edges.push_back(first.shaded_low);
    shaded.edges.push_back(first.shaded_high);
  }
  return shaded;
}

}  // namespace tandem
