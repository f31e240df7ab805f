#include "app/picture/chart.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace tandem {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::vector<std::string> TextsOf(const Axis& axis, int most) {
  std::vector<std::string> texts;
  for (const Tick& tick : TicksOf(axis, most)) {
    if (!tick.text.empty()) texts.push_back(tick.text);
  }
  return texts;
}

std::vector<PolylineShape> CurvesOf(const Picture& picture) {
  std::vector<PolylineShape> curves;
  for (const PictureShape& shape : picture.shapes) {
    if (const auto* curve = std::get_if<PolylineShape>(&shape)) curves.push_back(*curve);
  }
  return curves;
}

TEST(Chart, HasItsLogarithmicTicksAtOneTwoAndFiveOfADecade) {
  EXPECT_EQ(TextsOf({"delay, ms", 10, 1000, true}, 8),
            (std::vector<std::string>{"10", "20", "50", "100", "200", "500", "1000"}));
  // too many ticks for the place: whole decades
  EXPECT_EQ(TextsOf({"delay, ms", 10, 1000, true}, 4),
            (std::vector<std::string>{"10", "100", "1000"}));
  EXPECT_EQ(TextsOf({"stiffness, N/m", 4, 2000, true}, 12),
            (std::vector<std::string>{"5", "10", "20", "50", "100", "200", "500", "1000", "2000"}));
}

TEST(Chart, HasItsLinearTicksAtRoundValuesAndNoMoreThanAskedFor) {
  EXPECT_EQ(TextsOf({"t, s", 0, 12, false}, 6),
            (std::vector<std::string>{"0", "2", "4", "6", "8", "10", "12"}));
  EXPECT_EQ(TextsOf({"growth, 1/s", -0.3, 0.31, false}, 4),
            (std::vector<std::string>{"-0.2", "0", "0.2"}));
}

TEST(Chart, PutsAGeometricMeanInTheMiddleOfALogarithmicAxis) {
  Picture picture;
  const Chart chart(picture, {100, 50, 400, 200}, {"x", 10, 1000, true}, {"y", 0, 8, false});
  const PicturePoint middle = chart.At(100, 4);
  EXPECT_NEAR(middle.x, 300, 1e-9);
  EXPECT_NEAR(middle.y, 150, 1e-9);
  EXPECT_NEAR(chart.At(10, 0).y, 250, 1e-9);  // zero is below
}

TEST(Chart, CutsACurveWhereItLeavesTheBox) {
  Picture picture;
  Chart chart(picture, {0, 0, 100, 100}, {"x", 0, 10, false}, {"y", 0, 10, false});
  // up and out at (5, 10), back in at (7, 10)
  chart.DrawCurve({{0, 0}, {6, 12}, {8, 8}}, {kBlack, 1, {}});
  const std::vector<PolylineShape> curves = CurvesOf(picture);
  ASSERT_EQ(curves.size(), 2U);
  ASSERT_EQ(curves[0].points.size(), 2U);
  EXPECT_NEAR(curves[0].points[1].x, 50, 1e-9);
  EXPECT_NEAR(curves[0].points[1].y, 0, 1e-9);
  ASSERT_EQ(curves[1].points.size(), 2U);
  EXPECT_NEAR(curves[1].points[0].x, 70, 1e-9);
  EXPECT_NEAR(curves[1].points[0].y, 0, 1e-9);
}

TEST(Chart, NonFiniteValueBreaksTheCurve) {
  Picture picture;
  Chart chart(picture, {0, 0, 100, 100}, {"x", 0, 10, false}, {"y", 0, 10, false});
  chart.DrawCurve({{1, 1}, {2, 2}, {3, kNaN}, {4, 4}, {5, 5}}, {kBlack, 1, {}});
  const std::vector<PolylineShape> curves = CurvesOf(picture);
  ASSERT_EQ(curves.size(), 2U);
  EXPECT_NEAR(curves[0].points.back().x, 20, 1e-9);
  EXPECT_NEAR(curves[1].points.front().x, 40, 1e-9);
}

TEST(Chart, OmitsValuesWithoutALogarithm) {
  Picture picture;
  Chart chart(picture, {0, 0, 100, 100}, {"x", 1, 10, true}, {"y", 1, 10, true});
  chart.DrawCurve({{1, 0}, {2, -3}, {3, 3}, {4, 4}}, {kBlack, 1, {}});
  const std::vector<PolylineShape> curves = CurvesOf(picture);
  ASSERT_EQ(curves.size(), 1U);
  EXPECT_EQ(curves[0].points.size(), 2U);
}

TEST(Chart, HasNoTicksOnALogarithmicAxisThatHasNoLength) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(TicksOf({"x", 0, 10, true}, 8).empty());
  EXPECT_TRUE(TicksOf({"x", -1, 10, true}, 8).empty());
  EXPECT_TRUE(TicksOf({"x", 10, 10, true}, 8).empty());
  EXPECT_TRUE(TicksOf({"x", 1, kInfinity, true}, 8).empty());
  EXPECT_TRUE(TicksOf({"x", kNaN, 10, true}, 8).empty());
}

// At 1e17 a step of 10 is less than the gap to the next number in double.
TEST(Chart, EndsItsLinearTicksFarFromZero) {
  EXPECT_LE(TicksOf({"x", 1e17, 1e17 + 64, false}, 8).size(), 10U);
}

}  // namespace
}  // namespace tandem
