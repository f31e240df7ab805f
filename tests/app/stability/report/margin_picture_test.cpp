#include "app/stability/report/margin_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/stability/report/map_picture.h"
#include "tests/app/stability/report/made_results.h"

namespace tandem {
namespace {

using testing::ReplaceInCase;
using testing::TwentyCells;

/// Returns the height of the mark of a cell's hint in the picture, from above.
double HeightOf(const Picture& picture, const std::string& cell) {
  for (const PictureShape& shape : picture.shapes) {
    const auto* const mark = std::get_if<MarkerShape>(&shape);
    if (mark != nullptr && mark->hint.starts_with(cell + ":")) return mark->at.y;
  }
  ADD_FAILURE() << "no mark of " << cell;
  return std::numeric_limits<double>::quiet_NaN();
}

bool HasText(const Picture& picture, const std::string& text) {
  return std::ranges::any_of(picture.shapes, [&text](const PictureShape& shape) {
    const auto* const label = std::get_if<LabelShape>(&shape);
    return label != nullptr && label->text == text;
  });
}

// Forces saturate: a run that swings at its bounds no longer grows, and is no nearer to stability
// than a run that parts.
TEST(MarginPicture, PlacesBoundedOscillationsWithExplosions) {
  Results results = TwentyCells();
  CaseResult& swings = results.records.at(8).outcome.result;  // 270 N/m at 100 ms
  swings.metrics.diverged = false;
  swings.metrics.growth = 0.01;
  swings.metrics.tail_rms = 0.5;
  results.records.at(9).outcome.result.metrics.diverged = true;
  const Picture picture = MarginPictureOf(results, "margin");
  EXPECT_EQ(HeightOf(picture, "cell 8"), HeightOf(picture, "cell 9"));
}

TEST(MarginPicture, HasABarOverTheSeedsGrowthRange) {
  Results results = TwentyCells();
  EXPECT_FALSE(HasText(MarginPictureOf(results, "margin"), "least to greatest of a case's seeds"));
  const double growths[] = {-1.5, 0.5, -0.5};
  for (std::size_t i = 0; i < 3; ++i) {
    CellRecord record = results.records.at(6);
    record.cell.number = 20 + i;
    ReplaceInCase(record, "\"seed\":7", "\"seed\":" + std::to_string(70 + i));
    record.outcome.result.metrics.growth = growths[i];
    results.records.emplace(record.cell.number, record);
  }
  results.records.erase(6);
  const Picture picture = MarginPictureOf(results, "margin");
  EXPECT_TRUE(HasText(picture, "least to greatest of a case's seeds"));
  const double top = HeightOf(picture, "cell 21");
  const double bottom = HeightOf(picture, "cell 20");
  EXPECT_TRUE(std::ranges::any_of(picture.shapes, [&](const PictureShape& shape) {
    const auto* const line = std::get_if<PolylineShape>(&shape);
    if (line == nullptr || line->points.size() != 2) return false;
    const auto [low, high] = std::minmax(line->points[0].y, line->points[1].y);
    return std::abs(low - top) < 0.5 && std::abs(high - bottom) < 0.5;
  }));
}

}  // namespace
}  // namespace tandem
