#include "scenes/generators/shapes.h"

#include <cmath>

#include <gmock/gmock.h>

#include "tests/scenes/generators/solid_probe.h"

namespace tandem {
namespace {

double Volume(const TriangleMesh& mesh) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    sum += mesh.corner(t, 0).dot(mesh.corner(t, 1).cross(mesh.corner(t, 2))) / 6;
  }
  return sum;
}

// Returns the area of a regular polygon of n sides, of that circumradius.
double PolygonArea(double radius, int n) {
  return 0.5 * n * radius * radius * std::sin(2 * M_PI / n);
}

TEST(Shapes, AreClosedAndTurnedOutward) {
  PlateEdges edges;
  edges.outer_round = 2;
  edges.hole_round = 1;
  const Outline square = {{{20, 20}, 0}, {{-20, 20}, 0}, {{-20, -20}, 0}, {{20, -20}, 0}};
  for (const TriangleMesh& shape :
       {Box({-1, -2, -3}, {1, 2, 3}), Revolved({{5, 0}, {5, 10}, {2, 12}}, 24),
        RevolvedRing({{5, 0}, {7, 0}, {7, 3}, {5, 3}}, 24),
        Plate(square, {{{0, 0}, 5}}, 1, 9, edges),
        Hose({{0, 0, 0}, {40, 0, 0}, {60, 20, 10}}, 5, 0.3, 12, 20), HexHead(13, 8),
        ThreadedEnd(4, 1.25, 12, 24), OctahedralSphere(5, 2, false), HalfCup(5, 8, 3),
        AlongX(HexHead(13, 8)), AlongY(HexHead(13, 8)),
        Prism({{0, 0}, {4, 0}, {4, 1}, {1, 1}, {1, 3}, {4, 3}, {4, 4}, {0, 4}}, 0, 2)}) {
    EXPECT_TRUE(ClosedAndTurnedOutward(shape)) << shape.triangles.size();
  }
}

TEST(Shapes, HaveTheirAnalyticVolumes) {
  EXPECT_NEAR(Volume(Box({-1, -2, -3}, {1, 2, 3})), 48, 1e-9);
  EXPECT_NEAR(Volume(Revolved({{5, 0}, {5, 10}}, 24)), 10 * PolygonArea(5, 24), 1e-9);
  EXPECT_NEAR(Volume(RevolvedRing({{5, 0}, {7, 0}, {7, 3}, {5, 3}}, 24)),
              3 * (PolygonArea(7, 24) - PolygonArea(5, 24)), 1e-9);
  // a C of 16 less a gap of 3 x 2
  EXPECT_NEAR(Volume(Prism({{0, 0}, {4, 0}, {4, 1}, {1, 1}, {1, 3}, {4, 3}, {4, 4}, {0, 4}}, 0, 2)),
              20, 1e-9);
  const Outline square = {{{20, 20}, 0}, {{-20, 20}, 0}, {{-20, -20}, 0}, {{20, -20}, 0}};
  EXPECT_NEAR(Volume(Plate(square, {{{0, 0}, 5}}, 1, 9, {})), 8 * (1600 - M_PI * 25),
              8 * M_PI * 25 * 0.002);
}

TEST(Shapes, OutlineMatchesItsHull) {
  const Outline slot = {{{-3, 0}, 2}, {{3, 0}, 2}};
  EXPECT_NEAR(Reach(slot, 0), 5, 1e-4);
  EXPECT_NEAR(Reach(slot, M_PI), 5, 1e-4);
  EXPECT_NEAR(Reach(slot, M_PI / 2), 2, 1e-4);
  EXPECT_NEAR(Reach(slot, M_PI / 4), 2 * std::sqrt(2.0), 1e-4);  // on the straight side
}

TEST(Shapes, OctahedralSphereQuadruplesPerLevelAndLiesOnTheSphere) {
  const TriangleMesh sphere = OctahedralSphere(3, 3, false);
  EXPECT_EQ(sphere.triangles.size(), 8U * 4 * 4 * 4);
  for (const Vec3& vertex : sphere.vertices) EXPECT_NEAR(vertex.norm(), 3, 1e-12);
  EXPECT_NEAR(Volume(sphere), 4.0 / 3 * M_PI * 27, 0.03 * 4.0 / 3 * M_PI * 27);
}

TEST(SolidProbe, ReportsContainmentAndDistanceOfABox) {
  const SolidProbe probe(Box({0, 0, 0}, {10, 20, 30}), 6);
  EXPECT_TRUE(probe.Inside({5, 5, 5}));
  EXPECT_FALSE(probe.Inside({5, 5, 31}));
  EXPECT_FALSE(probe.Inside({-1, 5, 5}));
  EXPECT_NEAR(probe.Distance({5, 5, 33}), 3, 1e-12);
  EXPECT_NEAR(probe.Distance({13, 24, 5}), 5, 1e-12);
  EXPECT_NEAR(probe.Distance({5, 10, 15}), 5, 1e-12);
  EXPECT_NEAR(probe.Distance({5, 10, 100}), 6, 1e-12);
}

}  // namespace
}  // namespace tandem
