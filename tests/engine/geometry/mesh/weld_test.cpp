#include "engine/geometry/mesh/weld.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace tandem {
namespace {

double Distance(const FloatPoint& a, const FloatPoint& b) {
  return std::hypot(double{a[0]} - double{b[0]}, double{a[1]} - double{b[1]},
                    double{a[2]} - double{b[2]});
}

std::vector<FloatPoint> RandomPoints(std::size_t count, unsigned seed, int steps) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> coordinate(-steps, steps);
  const auto draw = [&] {
    return 0.1F * static_cast<float>(coordinate(random));
  };
  std::vector<FloatPoint> points(count);
  for (FloatPoint& p : points) p = {draw(), draw(), draw()};
  return points;
}

TEST(Weld, JoinsOnlyEqualPositions) {
  const std::vector<FloatPoint> points = RandomPoints(600, 7, 4);
  const Weld weld = WeldEqual(points);
  ASSERT_EQ(weld.vertex_of_point.size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = 0; j < points.size(); ++j) {
      ASSERT_EQ(weld.vertex_of_point[i] == weld.vertex_of_point[j], points[i] == points[j]);
    }
    EXPECT_EQ(points[weld.first_point[weld.vertex_of_point[i]]], points[i]);
  }
}

TEST(Weld, DistinguishesAdjacentFloatsButNotSignedZeros) {
  const std::vector<FloatPoint> points{
      {0.0F, 1.0F, -0.0F}, {-0.0F, 1.0F, 0.0F}, {0.0F, std::nextafter(1.0F, 2.0F), 0.0F}};
  const Weld weld = WeldEqual(points);
  EXPECT_EQ(weld.vertex_of_point, (std::vector<std::uint32_t>{0, 0, 1}));
}

TEST(Weld, ToleranceBoundsMotionAndSeparatesVertices) {
  const std::vector<FloatPoint> points = RandomPoints(800, 11, 30);
  const double tolerance = 0.35;
  const Weld weld = WeldNear(points, tolerance);
  EXPECT_LT(weld.first_point.size(), WeldEqual(points).first_point.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_LE(Distance(points[i], points[weld.first_point[weld.vertex_of_point[i]]]), tolerance);
  }
  for (std::size_t i = 0; i < weld.first_point.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      ASSERT_GT(Distance(points[weld.first_point[i]], points[weld.first_point[j]]), tolerance);
    }
  }
}

TEST(Weld, ToleranceBelowFloatPrecisionIsZero) {
  const std::vector<FloatPoint> points{{1e30F, 0, 0}, {1e30F, 0, 0}, {1, 0, 0}};
  EXPECT_EQ(WeldNear(points, 1e-30).first_point.size(), 2U);
  EXPECT_EQ(WeldNear(points, 0).first_point.size(), 2U);
  EXPECT_TRUE(WeldNear({}, 1).first_point.empty());
}

}  // namespace
}  // namespace tandem
