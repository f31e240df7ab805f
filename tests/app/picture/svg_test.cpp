#include "app/picture/svg.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tandem {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

Picture OneOfEach() {
  Picture picture{"one", "a & b", 200, 100, {}};
  picture.shapes.emplace_back(RectangleShape{{10, 20, 30.125, 40}, Rgb{255, 128, 0}, {}, "cell 3"});
  picture.shapes.emplace_back(PolylineShape{{{0, 0}, {10.5, 20}}, {kBlack, 2, {4, 3}}});
  picture.shapes.emplace_back(MarkerShape{{50, 60}, MarkerKind::kCross, 6, kBlack, {}});
  picture.shapes.emplace_back(MarkerShape{{70, 60}, MarkerKind::kDot, 6, kBlack, {}});
  picture.shapes.emplace_back(
      LabelShape{{5, 90}, "k < 0.9 k_crit", 12, TextAnchor::kMiddle, kBlack, true, true});
  return picture;
}

TEST(Svg, WritesEveryShapeInOrder) {
  const std::string svg = SvgOf(OneOfEach(), SvgPlace::kFile);
  const std::size_t rectangle = svg.find(
      R"(<rect x="10" y="20" width="30.12" height="40" fill="#ff8000"><title>cell 3</title></rect>)");
  const std::size_t line = svg.find(R"(<polyline points="0,0 10.5,20" fill="none")");
  const std::size_t cross = svg.find(R"(<path d="M47 57L53 63M47 63L53 57")");
  const std::size_t dot = svg.find(R"(<circle cx="70" cy="60" r="3" fill="#000000"/>)");
  const std::size_t text = svg.find("k &lt; 0.9 k_crit</text>");
  ASSERT_NE(text, std::string::npos) << svg;
  EXPECT_LT(rectangle, line);
  EXPECT_LT(line, cross);
  EXPECT_LT(cross, dot);
  EXPECT_LT(dot, text);
  EXPECT_THAT(svg, HasSubstr(R"(stroke-dasharray="4 3")"));
  EXPECT_THAT(svg, HasSubstr("rotate(-90 5 90)"));
}

TEST(Svg, NamesItsLanguageOnlyInAStandaloneFile) {
  EXPECT_THAT(SvgOf(OneOfEach(), SvgPlace::kFile), HasSubstr("xmlns="));
  EXPECT_THAT(SvgOf(OneOfEach(), SvgPlace::kInHtml), Not(HasSubstr("http")));
}

TEST(Svg, EscapesText) {
  EXPECT_THAT(SvgOf(OneOfEach(), SvgPlace::kFile), HasSubstr(R"(aria-label="a &amp; b")"));
}

}  // namespace
}  // namespace tandem
