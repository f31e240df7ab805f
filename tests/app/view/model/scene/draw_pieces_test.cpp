#include "app/view/model/scene/draw_pieces.h"

#include <algorithm>
#include <array>

#include <gtest/gtest.h>

#include "tests/app/view/shapes.h"

namespace tandem {
namespace {

/// Returns a ball of 2 * around * (rings - 1) triangles with area towards the equator: three pieces
/// and a bit.
ShadedMesh LargeBall() {
  return Shade(SphereMesh(0.1, 201, 128), kCreaseAngle);
}

std::vector<std::array<std::uint32_t, 3>> SortedTriangles(const std::vector<std::uint32_t>& list) {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (std::size_t i = 0; i < list.size(); i += 3) {
    triangles.push_back({list[i], list[i + 1], list[i + 2]});
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

double AreaOf(const ShadedMesh& mesh, const std::vector<std::uint32_t>& list, std::size_t first,
              std::size_t count) {
  double area = 0;
  for (std::size_t i = first; i < first + count; i += 3) {
    const auto p = [&](std::size_t k) {
      const auto& at = mesh.vertices[list[i + k]].p;
      return Vec3(at[0], at[1], at[2]);
    };
    area += 0.5 * (p(1) - p(0)).cross(p(2) - p(0)).norm();
  }
  return area;
}

TEST(DrawPieces, ASmallMeshKeepsItsOrder) {
  const ShadedMesh mesh = Shade(SphereMesh(0.1, 33, 32), kCreaseAngle);
  EXPECT_EQ(TrianglesInDrawingOrder(mesh), mesh.triangles);
}

TEST(DrawPieces, ALargeMeshIsDrawnLargestFirstAndKeepsEveryTriangle) {
  const ShadedMesh mesh = LargeBall();
  const std::vector<std::uint32_t> ordered = TrianglesInDrawingOrder(mesh);
  EXPECT_EQ(SortedTriangles(ordered), SortedTriangles(mesh.triangles));
  const std::size_t piece = 3 * kPieceTriangles;
  ASSERT_GT(ordered.size(), 3 * piece);
  // the area of a ball lies about its equator; the poles have as many triangles with less
  EXPECT_GT(AreaOf(mesh, ordered, 0, piece), 1.2 * AreaOf(mesh, ordered, piece, piece));
  EXPECT_GT(AreaOf(mesh, ordered, piece, piece), 1.2 * AreaOf(mesh, ordered, 2 * piece, piece));
}

TEST(DrawPieces, CoverFixedBodiesOnceTrianglesFirstInTurn) {
  DrawnScene scene = BlockAndBall();
  scene.bodies.push_back({"large", {true, {}}, LargeBall(), {}, 0});
  scene.bodies.back().mesh.edges = {0, 1, 2, 3};
  const std::vector<DrawPiece> pieces = PiecesOfFixedBodies(scene.bodies);
  std::vector<std::size_t> bodies;
  std::vector<std::size_t> of_triangles(3, 0);
  std::vector<std::size_t> of_edges(3, 0);
  for (const DrawPiece& piece : pieces) {
    bodies.push_back(piece.body);
    std::size_t& covered = (piece.edges ? of_edges : of_triangles)[piece.body];
    EXPECT_EQ(piece.first, covered);
    EXPECT_LE(piece.count, 3 * kPieceTriangles);
    covered += piece.count;
  }
  // the block has one piece and the large body four pieces; then come the edges of both
  EXPECT_EQ(bodies, (std::vector<std::size_t>{0, 2, 2, 2, 2, 0, 2}));
  EXPECT_TRUE(std::is_sorted(pieces.begin(), pieces.end(), [](const auto& a, const auto& b) {
    return a.edges < b.edges;
  }));
  for (const std::size_t body : {std::size_t{0}, std::size_t{2}}) {
    EXPECT_EQ(of_triangles[body], scene.bodies[body].mesh.triangles.size());
    EXPECT_EQ(of_edges[body], scene.bodies[body].mesh.edges.size());
  }
}

}  // namespace
}  // namespace tandem
