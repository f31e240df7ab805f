#include "app/stability/report/map_picture.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace tandem {
namespace {

template <class Shape>
std::vector<Shape> All(const Picture& picture) {
  std::vector<Shape> all;
  for (const PictureShape& shape : picture.shapes) {
    if (const auto* one = std::get_if<Shape>(&shape)) all.push_back(*one);
  }
  return all;
}

StabilityMap OfGrid() {
  StabilityMap map{"map-1",
                   "Stability by delay and stiffness: free, 2 users, hands heavy",
                   "constant gains, drag 10 N s/m; network clean, states at 1000 Hz",
                   {},
                   {}};
  for (int i = 0; i < 15; ++i) {
    for (int j = 0; j < 18; ++j) {
      const double delay = 0.01 * std::pow(100.0, i / 14.0);
      const double stiffness = 4 * std::pow(500.0, j / 17.0);
      const double growth = std::log(stiffness * delay / 10);
      map.cells.push_back({delay, stiffness, growth,
                           growth > 0 ? Verdict::kUnstable : Verdict::kStable,
                           "cell " + std::to_string(map.cells.size())});
    }
  }
  const std::vector<std::pair<MapLineKind, std::string>> lines{
      {MapLineKind::kBoundary, "exact boundary"},
      {MapLineKind::kPassive, "passive: b / delay"},
      {MapLineKind::kAnyDelay, "stable at any delay"},
      {MapLineKind::kLaw, "law in use: p+d"},
      {MapLineKind::kLinearCalm, "paper's linear law, 40 N/m"},
      {MapLineKind::kLinearFirm, "paper's linear law, 200 N/m"}};
  for (const auto& line : lines) {
    map.lines.push_back({line.first, line.second, {{0.01, 1000}, {0.1, 100}, {1, 10}}});
  }
  return map;
}

double Luminance(const Rgb& colour) {
  const auto linear = [](std::uint8_t value) {
    const double share = value / 255.0;
    return share <= 0.04045 ? share / 12.92 : std::pow((share + 0.055) / 1.055, 2.4);
  };
  return 0.2126 * linear(colour.r) + 0.7152 * linear(colour.g) + 0.0722 * linear(colour.b);
}

TEST(GrowthColour, IsWhiteAtZeroBlueBelowAndRedAbove) {
  EXPECT_EQ(GrowthColour(0), kWhite);
  EXPECT_GT(GrowthColour(-1).b, GrowthColour(-1).r + 40);
  EXPECT_GT(GrowthColour(1).r, GrowthColour(1).b + 40);
  EXPECT_EQ(GrowthColour(9), GrowthColour(kMostGrowth));
  EXPECT_EQ(GrowthColour(std::numeric_limits<double>::infinity()), GrowthColour(kMostGrowth));
  const Rgb none = GrowthColour(std::nan(""));
  EXPECT_EQ(none.r, none.b);  // grey
}

// WCAG 2.1, 1.4.11: graphics need a contrast of 3 to 1.
TEST(GrowthColour, KeepsBlackMarksVisible) {
  for (double growth = -2.5; growth <= 2.5; growth += 0.05) {
    EXPECT_GT((Luminance(GrowthColour(growth)) + 0.05) / 0.05, 5.0) << growth;
  }
}

// The commonest kinds of colour-blindness leave blue.
TEST(GrowthColour, SeparatesStableFromUnstableByTheBlueChannel) {
  for (const double growth : {0.5, 1.0, 2.0}) {
    EXPECT_GT(GrowthColour(-growth).b, GrowthColour(growth).b + 30) << growth;
  }
}

TEST(StabilityMap, EveryCellHasATileAMarkAndAHint) {
  const StabilityMap map = OfGrid();
  const Picture picture = PictureOf(map);
  std::size_t tiles = 0;
  for (const RectangleShape& tile : All<RectangleShape>(picture))
    tiles += tile.hint.empty() ? 0 : 1;
  EXPECT_EQ(tiles, map.cells.size());
  std::size_t crosses = 0;
  std::size_t marks = 0;
  for (const MarkerShape& mark : All<MarkerShape>(picture)) {
    if (mark.hint.empty()) continue;  // mark of the legend
    ++marks;
    crosses += mark.kind == MarkerKind::kCross ? 1 : 0;
  }
  EXPECT_EQ(marks, map.cells.size());
  std::size_t unstable = 0;
  for (const MapCell& cell : map.cells) unstable += cell.verdict == Verdict::kUnstable ? 1 : 0;
  EXPECT_EQ(crosses, unstable);
}

TEST(StabilityMap, EachMarkIsInItsOwnTile) {
  const Picture picture = PictureOf(OfGrid());
  std::vector<RectangleShape> tiles;
  for (const RectangleShape& tile : All<RectangleShape>(picture)) {
    if (!tile.hint.empty()) tiles.push_back(tile);
  }
  for (const MarkerShape& mark : All<MarkerShape>(picture)) {
    if (mark.hint.empty()) continue;
    int around = 0;
    for (const RectangleShape& tile : tiles) {
      const PictureBox& box = tile.box;
      if (mark.at.x <= box.x || mark.at.x >= box.right()) continue;
      if (mark.at.y <= box.y || mark.at.y >= box.bottom()) continue;
      ++around;
      EXPECT_EQ(tile.hint, mark.hint);
    }
    EXPECT_EQ(around, 1) << mark.hint;
  }
}

TEST(StabilityMap, TextsNeitherOverlapNorLeaveThePicture) {
  const Picture picture = PictureOf(OfGrid());
  const std::vector<LabelShape> labels = All<LabelShape>(picture);
  ASSERT_GT(labels.size(), 20U);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const PictureBox box = BoundsOf(labels[i]);
    EXPECT_GE(box.x, 0) << labels[i].text;
    EXPECT_GE(box.y, 0) << labels[i].text;
    EXPECT_LE(box.right(), picture.width) << labels[i].text;
    EXPECT_LE(box.bottom(), picture.height) << labels[i].text;
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_FALSE(box.Overlaps(BoundsOf(labels[j]))) << labels[i].text << " on " << labels[j].text;
    }
  }
}

TEST(StabilityMap, AxesHaveUnits) {
  std::string texts;
  for (const LabelShape& label : All<LabelShape>(PictureOf(OfGrid()))) texts += label.text + "\n";
  for (const char* unit : {"delay, ms", "N/m", "growth of the velocities, 1/s"}) {
    EXPECT_NE(texts.find(unit), std::string::npos) << unit;
  }
}

// the middle of the map's range is the middle of the plot, on both logarithmic
// axes
TEST(StabilityMap, DelayAxisIsLogarithmic) {
  StabilityMap map{"m", "t", "n", {}, {}};
  for (const double delay : {0.01, 0.1, 1.0}) {
    map.cells.push_back({delay, 100 * delay / 0.1, 0, Verdict::kStable, "cell"});
  }
  std::vector<MarkerShape> marks;
  for (const MarkerShape& mark : All<MarkerShape>(PictureOf(map))) {
    if (!mark.hint.empty()) marks.push_back(mark);
  }
  ASSERT_EQ(marks.size(), 3U);
  EXPECT_NEAR(marks[1].at.x, 0.5 * (marks[0].at.x + marks[2].at.x), 1e-6);
  EXPECT_NEAR(marks[1].at.y, 0.5 * (marks[0].at.y + marks[2].at.y), 1e-6);
  EXPECT_LT(marks[2].at.y, marks[0].at.y);  // firmer is higher
}

TEST(StabilityMap, MarksHaveOneSizeInMapAndLegend) {
  double of_dots[2] = {0, 0};
  double of_crosses[2] = {0, 0};
  for (const MarkerShape& mark : All<MarkerShape>(PictureOf(OfGrid()))) {
    (mark.kind == MarkerKind::kDot ? of_dots : of_crosses)[mark.hint.empty() ? 0 : 1] = mark.size;
  }
  EXPECT_GE(of_dots[1], 6);
  EXPECT_EQ(of_dots[0], of_dots[1]);
  EXPECT_EQ(of_crosses[0], of_crosses[1]);
}

// The map goes from 4 to 2000 N/m and from 10 ms to 1 s.
TEST(StabilityMap, LegendOmitsLinesOutsideTheMap) {
  StabilityMap map = OfGrid();
  const double none = std::nan("");
  map.lines = {{MapLineKind::kBoundary, "above", {{0.01, 1e5}, {1, 1e4}}},
               {MapLineKind::kPassive, "through", {{0.1, 1e5}, {0.2, 1}}},
               {MapLineKind::kAnyDelay, "below", {{0.01, 0.5}, {1, 0.5}}},
               {MapLineKind::kLaw, "beside", {{3, 100}, {4, 100}}},
               {MapLineKind::kLinearCalm, "nowhere", {{0.01, none}, {1, none}}},
               {MapLineKind::kLinearFirm, "inside", {{0.01, 20}, {1, 20}}}};
  std::string texts;
  for (const LabelShape& label : All<LabelShape>(PictureOf(map))) texts += label.text + "\n";
  for (const char* there : {"through", "inside"}) {
    EXPECT_NE(texts.find(there), std::string::npos) << there;
  }
  for (const char* not_there : {"above", "below", "beside", "nowhere"}) {
    EXPECT_EQ(texts.find(not_there), std::string::npos) << not_there;
  }
}

TEST(StabilityMap, LongTitleFits) {
  StabilityMap map = OfGrid();
  map.title += ", network delays that change 20 ms 300 ms 50 ms 1000 ms 20 ms, jitter 30 ms";
  map.note += map.note;
  const Picture picture = PictureOf(map);
  for (const LabelShape& label : All<LabelShape>(picture)) {
    EXPECT_LE(BoundsOf(label).right(), picture.width) << label.text;
  }
}

}  // namespace
}  // namespace tandem
