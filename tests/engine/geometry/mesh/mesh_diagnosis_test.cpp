#include "engine/geometry/mesh/mesh_diagnosis.h"

#include <array>
#include <map>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include "tests/engine/geometry/shapes.h"

namespace tandem {
namespace {

using testing::BoxMesh;
using testing::MovedBy;

TEST(MeshDiagnosis, BoxIsFaultless) {
  const MeshDiagnosis box = Diagnose(BoxMesh(Vec3(1, 2, 3)));
  EXPECT_TRUE(box.closed());
  EXPECT_EQ(box.bodies, 1U);
  EXPECT_EQ(box.flat_triangles, 0U);
  EXPECT_EQ(Describe(box), "closed, 1 body");
}

TEST(MeshDiagnosis, LabelsConnectedTriangles) {
  TriangleMesh mesh = BoxMesh(Vec3::Constant(1));
  Append(mesh, MovedBy(BoxMesh(Vec3::Constant(1)), Vec3(5, 0, 0)));
  std::swap(mesh.triangles[3], mesh.triangles[20]);
  const MeshDiagnosis both = Diagnose(mesh);
  EXPECT_EQ(both.bodies, 2U);
  ASSERT_EQ(both.body_of_triangle.size(), 24U);
  for (std::size_t t = 0; t < 24; ++t) {
    EXPECT_EQ(both.body_of_triangle[t], mesh.corner(t, 0).x() < 3 ? 0U : 1U) << t;
  }
  EXPECT_EQ(Describe(both), "closed, 2 bodies");
}

TEST(MeshDiagnosis, CountsTheEdgesOfAHole) {
  TriangleMesh mesh = BoxMesh(Vec3::Constant(1));
  mesh.triangles.pop_back();
  const MeshDiagnosis open = Diagnose(mesh);
  EXPECT_EQ(open.open_edges, 3U);
  EXPECT_FALSE(open.closed());
  EXPECT_EQ(Describe(open), "3 open edges; 1 body");
}

TEST(MeshDiagnosis, CountsTheEdgesOfATurnedTriangle) {
  TriangleMesh mesh = BoxMesh(Vec3::Constant(1));
  std::swap(mesh.triangles[0][0], mesh.triangles[0][1]);
  const MeshDiagnosis flipped = Diagnose(mesh);
  EXPECT_EQ(flipped.flipped_edges, 3U);
  EXPECT_EQ(flipped.open_edges, 0U);
  EXPECT_FALSE(flipped.closed());
}

// Two boxes that share an edge and nothing else: four triangles meet there.
TEST(MeshDiagnosis, CountsEdgesThatMoreThanTwoTrianglesUse) {
  TriangleMesh mesh = BoxMesh(Vec3::Constant(1));
  Append(mesh, MovedBy(BoxMesh(Vec3::Constant(1)), Vec3(1, 1, 0)));
  for (TriangleMesh::Triangle& t : mesh.triangles) {
    for (std::uint32_t& i : t) {
      if (i == 8) i = 3;   // (1, 1, 0)
      if (i == 12) i = 7;  // (1, 1, 1)
    }
  }
  const MeshDiagnosis diagnosis = Diagnose(mesh);
  EXPECT_EQ(diagnosis.non_manifold_edges, 1U);
  EXPECT_EQ(diagnosis.bodies, 1U);
  EXPECT_EQ(Describe(diagnosis), "1 non-manifold edge; 1 body");
}

// A triangle with one vertex twice is reported, but its edge is no edge of the surface.
TEST(MeshDiagnosis, CountsFlatTrianglesAndLooksPastCollapsedOnes) {
  TriangleMesh mesh = BoxMesh(Vec3::Constant(1));
  mesh.triangles.push_back({0, 1, 1});
  const MeshDiagnosis collapsed = Diagnose(mesh);
  EXPECT_TRUE(collapsed.closed());
  EXPECT_EQ(collapsed.flat_triangles, 1U);
  EXPECT_EQ(Describe(collapsed), "closed, 1 flat triangle; 1 body");

  // a needle of three vertices on a line has edges like any other
  mesh.triangles.pop_back();
  mesh.vertices.emplace_back(0.25, 0, 0);
  mesh.triangles.push_back({0, 8, 1});
  const MeshDiagnosis needle = Diagnose(mesh);
  EXPECT_EQ(needle.flat_triangles, 1U);
  EXPECT_EQ(needle.open_edges, 2U);
  EXPECT_EQ(needle.non_manifold_edges, 1U);
}

// Triangles between few vertices at random: edges of every fault, of which one map is the oracle.
TEST(MeshDiagnosis, CountsTheFaultsOfEveryEdgeOfTrianglesAtRandom) {
  std::mt19937 random(21);
  for (int round = 0; round < 20; ++round) {
    TriangleMesh mesh;
    for (int v = 0; v < 12; ++v) mesh.vertices.emplace_back(v, v * v % 7, v * v * v % 11);
    for (int t = 0; t < 10 + 2 * round; ++t) {
      std::array<std::uint32_t, 12> order{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};
      for (std::size_t i = 0; i < 3; ++i) std::swap(order[i], order[i + random() % (12 - i)]);
      mesh.triangles.push_back({order[0], order[1], order[2]});
    }
    // a count for each direction of each edge
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> runs;
    for (const TriangleMesh::Triangle& t : mesh.triangles) {
      for (std::size_t k = 0; k < 3; ++k) ++runs[{t[k], t[(k + 1) % 3]}];
    }
    std::size_t open = 0;
    std::size_t flipped = 0;
    std::size_t non_manifold = 0;
    for (std::uint32_t a = 0; a < 12; ++a) {
      for (std::uint32_t b = 0; b < a; ++b) {
        const int up = runs[{b, a}];
        const int down = runs[{a, b}];
        open += up + down == 1 ? 1U : 0U;
        flipped += (up == 2 && down == 0) || (up == 0 && down == 2) ? 1U : 0U;
        non_manifold += up + down > 2 ? 1U : 0U;
      }
    }
    const MeshDiagnosis diagnosis = Diagnose(mesh);
    EXPECT_EQ(diagnosis.open_edges, open) << round;
    EXPECT_EQ(diagnosis.flipped_edges, flipped) << round;
    EXPECT_EQ(diagnosis.non_manifold_edges, non_manifold) << round;
  }
}

TEST(MeshDiagnosis, EmptyMeshIsClosedWithoutBodies) {
  EXPECT_EQ(Describe(Diagnose({})), "closed, 0 bodies");
}

}  // namespace
}  // namespace tandem
