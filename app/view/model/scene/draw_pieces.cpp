#include "app/view/model/scene/draw_pieces.h"

#include <algorithm>
#include <numeric>

namespace tandem {

namespace {

constexpr std::size_t kRunIndices = 3 * 64;  // indices of a run, whose triangles share vertices in
                                             // the cache
constexpr std::size_t kPieceIndices = 3 * kPieceTriangles;

float TwiceTheArea(const ShadedMesh& mesh, std::size_t first) {
  const auto corner = [&](std::size_t k) {
    return Eigen::Map<const Eigen::Vector3f>(mesh.vertices[mesh.triangles[first + k]].p.data());
  };
  return (corner(1) - corner(0)).cross(corner(2) - corner(0)).norm();
}

void AddPieces(const std::vector<DrawnBody>& bodies, bool edges, std::vector<DrawPiece>& pieces) {
  bool more = true;
  for (std::size_t first = 0; more; first += kPieceIndices) {
    more = false;
    for (std::size_t body = 0; body < bodies.size(); ++body) {
      const ShadedMesh& mesh = bodies[body].mesh;
      const std::size_t all = edges ? mesh.edges.size() : mesh.triangles.size();
      if (!bodies[body].look.fixed || first >= all) continue;
      pieces.push_back({body, edges, first, std::min(kPieceIndices, all - first)});
      more = true;
    }
  }
}

}  // namespace

std::vector<std::uint32_t> TrianglesInDrawingOrder(const ShadedMesh& mesh) {
  if (mesh.triangles.size() <= kPieceIndices) return mesh.triangles;
  std::vector<float> areas((mesh.triangles.size() + kRunIndices - 1) / kRunIndices, 0.0F);
  for (std::size_t first = 0; first < mesh.triangles.size(); first += 3) {
    areas[first / kRunIndices] += TwiceTheArea(mesh, first);
  }
  std::vector<std::size_t> runs(areas.size());
  std::iota(runs.begin(), runs.end(), std::size_t{0});
  std::stable_sort(runs.begin(), runs.end(), [&](std::size_t a, std::size_t b) {
    return areas[a] > areas[b];
  });
  std::vector<std::uint32_t> ordered;
  ordered.reserve(mesh.triangles.size());
  for (const std::size_t run : runs) {
    const auto begin = mesh.triangles.begin() + static_cast<std::ptrdiff_t>(run * kRunIndices);
    const std::size_t left = mesh.triangles.size() - run * kRunIndices;
    ordered.insert(ordered.end(), begin,
                   begin + static_cast<std::ptrdiff_t>(std::min(kRunIndices, left)));
  }
  return ordered;
}

std::vector<DrawPiece> PiecesOfFixedBodies(const std::vector<DrawnBody>& bodies) {
  std::vector<DrawPiece> pieces;
  AddPieces(bodies, false, pieces);
  AddPieces(bodies, true, pieces);
  return pieces;
}

}  // namespace tandem
