#include "app/view/model/scene/refined_mesh.h"

#include <map>

#include <gtest/gtest.h>

#include "tests/app/view/shapes.h"

namespace tandem {
namespace {

Vec3 Coordinates(const std::array<float, 3>& a) {
  return {a[0], a[1], a[2]};
}

Vec3 Corner(const ShadedMesh& mesh, std::size_t i) {
  return Coordinates(mesh.vertices[mesh.triangles[i]].p);
}

double AreaOf(const ShadedMesh& mesh) {
  double area = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
    const Vec3 a = Corner(mesh, i);
    area += 0.5 * (Corner(mesh, i + 1) - a).cross(Corner(mesh, i + 2) - a).norm();
  }
  return area;
}

double LongestSideOf(const ShadedMesh& mesh) {
  double longest = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
    for (std::size_t k = 0; k < 3; ++k) {
      longest = std::max(longest, (Corner(mesh, i + k) - Corner(mesh, i + (k + 1) % 3)).norm());
    }
  }
  return longest;
}

/// Counts the sides that have no counterpart running the other way: cracks.
std::size_t CracksOf(const ShadedMesh& mesh) {
  using Point = std::array<float, 3>;
  std::map<std::pair<Point, Point>, int> sides;
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Point& a = mesh.vertices[mesh.triangles[i + k]].p;
      const Point& b = mesh.vertices[mesh.triangles[i + (k + 1) % 3]].p;
      sides[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  }
  std::size_t cracks = 0;
  for (const auto& [side, balance] : sides) cracks += balance != 0 ? 1 : 0;
  return cracks;
}

// A slab of 40 by 10 by 3 mm: its sides are cut one, two and three times a round.
TEST(Refine, CutsLongSidesAndLeavesTheSurfaceClosedAndInPlace) {
  ShadedMesh mesh = Shade(BoxMesh({0, 0, 0}, {0.04, 0.01, 0.003}), kCreaseAngle);
  const ShadedMesh before = mesh;
  ASSERT_EQ(CracksOf(before), 0U);
  Refine(mesh, 0.004, 100'000);
  EXPECT_LE(LongestSideOf(mesh), 0.004 + 1e-9);
  EXPECT_NEAR(AreaOf(mesh), AreaOf(before), 1e-8);
  EXPECT_EQ(CracksOf(mesh), 0U);
  EXPECT_EQ(mesh.edges, before.edges);
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
    const Vec3 a = Corner(mesh, i);
    const Vec3 n = (Corner(mesh, i + 1) - a).cross(Corner(mesh, i + 2) - a).normalized();
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_GT(n.dot(Coordinates(mesh.vertices[mesh.triangles[i + k]].n)), 0.999);
    }
  }
}

TEST(Refine, LeavesFineMeshesUnchanged) {
  ShadedMesh mesh = Shade(SphereMesh(0.01, 16, 32), kCreaseAngle);
  const std::vector<std::uint32_t> before = mesh.triangles;
  Refine(mesh, 0.005, 100'000);
  EXPECT_EQ(mesh.triangles, before);
  EXPECT_TRUE(mesh.uncut_triangles.empty());
}

TEST(Refine, KeepsTheVerticesOfSplitTriangles) {
  ShadedMesh mesh = Shade(BoxMesh({0, 0, 0}, {0.04, 0.01, 0.003}), kCreaseAngle);
  const ShadedMesh before = mesh;
  Refine(mesh, 0.004, 100'000);
  EXPECT_EQ(mesh.uncut_triangles, before.triangles);
  ASSERT_GT(mesh.vertices.size(), before.vertices.size());
  for (std::size_t v = 0; v < before.vertices.size(); ++v) {
    EXPECT_EQ(mesh.vertices[v].p, before.vertices[v].p);
    EXPECT_EQ(mesh.vertices[v].n, before.vertices[v].n);
  }
}

TEST(Refine, StopsBeforeThereAreTooManyVertices) {
  ShadedMesh mesh = Shade(BoxMesh({0, 0, 0}, {1, 1, 1}), kCreaseAngle);
  Refine(mesh, 0.001, 5000);
  EXPECT_LE(mesh.vertices.size(), 5000U);
  EXPECT_GT(mesh.vertices.size(), 1000U);
  EXPECT_EQ(CracksOf(mesh), 0U);
}

}  // namespace
}  // namespace tandem
