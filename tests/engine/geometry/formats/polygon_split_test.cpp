#include "engine/geometry/formats/polygon_split.h"

#include <cstddef>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

namespace tandem {
namespace {

double AreaOf(const std::vector<FilePoint>& points,
              const std::vector<TriangleMesh::Triangle>& triangles) {
  double area = 0;
  for (const TriangleMesh::Triangle& t : triangles) {
    const auto at = [&](std::size_t k) {
      return Vec3(points[t[k]][0], points[t[k]][1], points[t[k]][2]);
    };
    const double twice = (at(1) - at(0)).cross(at(2) - at(0)).z();
    EXPECT_GE(twice, 0);  // none is turned over
    area += twice / 2;
  }
  return area;
}

// A comb has as many ears as teeth; its area is that of the teeth and of the back.
TEST(PolygonSplit, PreservesTheAreaOfAConcavePolygon) {
  std::vector<FilePoint> points{{0, -1, 0}};
  std::vector<std::uint32_t> corners;
  constexpr int kTeeth = 50;
  points.push_back({2 * kTeeth, -1, 0});
  for (int i = kTeeth; i > 0; --i) {
    const double x = 2.0 * i;
    points.push_back({x, 0, 0});
    points.push_back({x - 1, 5, 0});
  }
  points.push_back({0, 0, 0});
  for (std::uint32_t i = 0; i < points.size(); ++i) corners.push_back(i);
  std::vector<TriangleMesh::Triangle> triangles;
  SplitPolygon(points, corners, triangles);
  EXPECT_EQ(triangles.size(), corners.size() - 2);
  // teeth of 2 x 5 / 2 on a back of 100 x 1
  EXPECT_NEAR(AreaOf(points, triangles), kTeeth * 5 + 2 * kTeeth, 1e-9);
}

TEST(PolygonSplit, CornersThatGoRoundSeveralTimesCountOnce) {
  const std::vector<FilePoint> points{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  std::vector<std::uint32_t> corners;
  for (std::uint32_t i = 0; i < 4 * 30; ++i) corners.push_back(i % 4);
  std::vector<TriangleMesh::Triangle> triangles;
  SplitPolygon(points, corners, triangles);
  EXPECT_EQ(triangles.size(), 2U);
  EXPECT_NEAR(AreaOf(points, triangles), 1, 1e-12);
}

// A square with a square hole that does not touch it, and one whose cut is a corner of both.
TEST(PolygonSplit, HolesStayOpen) {
  const std::vector<FilePoint> points{{0, 0, 0}, {4, 0, 0},   {4, 4, 0},  {0, 4, 0},
                                      {1, 1, 0}, {2, 1, 0},   {2, 2, 0},  {1, 2, 0},
                                      {3, 3, 0}, {3, 2.5, 0}, {2.5, 3, 0}};
  std::vector<TriangleMesh::Triangle> triangles;
  ASSERT_TRUE(SplitPolygonWithHoles(points, {0, 1, 2, 3}, {{4, 5, 6, 7}, {8, 9, 10}}, triangles));
  EXPECT_NEAR(AreaOf(points, triangles), 16 - 1 - 0.125, 1e-12);
  triangles.clear();
  EXPECT_FALSE(SplitPolygonWithHoles(points, {4, 5, 6, 7}, {{8, 9, 10}}, triangles));
  EXPECT_TRUE(triangles.empty());
}

TEST(PolygonSplit, PreservesASelfIntersectingPolygon) {
  const std::vector<FilePoint> points{{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::vector<std::uint32_t> corners{0, 1, 2, 3};
  std::vector<TriangleMesh::Triangle> triangles;
  SplitPolygon(points, corners, triangles);
  EXPECT_EQ(triangles.size(), 2U);
}

}  // namespace
}  // namespace tandem
