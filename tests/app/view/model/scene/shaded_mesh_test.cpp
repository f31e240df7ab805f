#include "app/view/model/scene/shaded_mesh.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/app/view/shapes.h"

namespace tandem {
namespace {

Vec3 ToVec3(const std::array<float, 3>& a) {
  return {a[0], a[1], a[2]};
}

TEST(Shade, GivesACubeSixFlatSidesAndTwelveEdges) {
  const ShadedMesh shaded = Shade(BoxMesh({-1, -1, -1}, {1, 1, 1}), kCreaseAngle);
  EXPECT_EQ(shaded.vertices.size(), 24U);  // three sides at each of eight corners
  EXPECT_EQ(shaded.triangles.size(), 36U);
  EXPECT_EQ(shaded.edges.size(), 24U);  // the diagonals of the sides are no edges
  for (const ShadedMesh::Vertex& v : shaded.vertices) {
    EXPECT_NEAR(ToVec3(v.n).cwiseAbs().maxCoeff(), 1.0, 1e-6);
    EXPECT_GT(ToVec3(v.n).dot(ToVec3(v.p)), 0);  // outwards
  }
}

TEST(Shade, GivesASphereSmoothNormalsAndNoEdges) {
  const ShadedMesh shaded = Shade(SphereMesh(0.05, 24, 48), kCreaseAngle);
  EXPECT_TRUE(shaded.edges.empty());
  for (const ShadedMesh::Vertex& v : shaded.vertices) {
    // facets of 7.5 degrees: the mean of those round a vertex is within one of them
    EXPECT_GT(ToVec3(v.n).dot(ToVec3(v.p).normalized()), std::cos(0.131));
  }
}

TEST(Shade, DrawsOpenRimsAndSkipsDegenerateTriangles) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 1, 3}};  // the second lies on a line
  const ShadedMesh shaded = Shade(mesh, kCreaseAngle);
  EXPECT_EQ(shaded.triangles.size(), 3U);
  EXPECT_EQ(shaded.edges.size(), 6U);
}

}  // namespace
}  // namespace tandem
