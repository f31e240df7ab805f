#include "app/stability/report/margin_picture.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "app/picture/chart.h"
#include "app/stability/report/cell_facts.h"
#include "app/stability/report/map_picture.h"

namespace tandem {

namespace {

constexpr PictureBox kMarginPlot{84, 64, 560, 360};
constexpr double kLeast = 0.02;  // least ratio of stiffness to boundary
constexpr double kMost = 20;
constexpr double kPredicted = 0.9;
constexpr Rgb kStable{0, 90, 160};
constexpr Rgb kUnstable{200, 60, 20};
constexpr Rgb kUndecided{110, 110, 110};
constexpr double kSize = 6;  // width of a mark, pixels

struct MarginMark {
  MarkerKind kind;
  Rgb colour;
};

MarginMark MarginMarkOf(Verdict verdict) {
  if (verdict == Verdict::kStable) return {MarkerKind::kDot, kStable};
  if (verdict == Verdict::kUnstable) return {MarkerKind::kCross, kUnstable};
  return {MarkerKind::kRing, kUndecided};
}

Stroke SeedStroke() {
  return {{150, 150, 150}, 3, {}};
}

/// The growths of one case over its seeds.
struct SeedSpan {
  std::vector<double> ratios;
  double least = kMostGrowth;
  double greatest = -kMostGrowth;
};

double ClampGrowth(double growth) {
  return std::clamp(growth, -kMostGrowth, kMostGrowth);
}

/// Draws a bar from the least to the greatest growth of each case that has several seeds. It stands
/// at the median of the case's ratios, which differ where jitter does. Returns whether there are
/// any.
bool DrawSeedSpans(const Results& results, Chart& chart) {
  std::map<std::string, SeedSpan> spans;
  for (const auto& numbered : results.records) {
    const CellOutcome& outcome = numbered.second.outcome;
    if (!outcome.predicted || outcome.result.fault) continue;
    const double ratio = outcome.predicted->stiffness / outcome.predicted->critical;
    const double growth = ShownGrowth(outcome.result);
    if (std::isnan(ratio) || std::isnan(growth)) continue;
    SeedSpan& span = spans[FactsOf(numbered.second).but_seed];
    span.ratios.push_back(std::clamp(ratio, kLeast, kMost));
    span.least = std::min(span.least, ClampGrowth(growth));
    span.greatest = std::max(span.greatest, ClampGrowth(growth));
  }
  bool any = false;
  for (auto& one : spans) {
    SeedSpan& span = one.second;
    if (span.ratios.size() < 2) continue;
    std::ranges::sort(span.ratios);
    const double ratio = span.ratios[span.ratios.size() / 2];
    chart.DrawCurve({{ratio, span.least}, {ratio, span.greatest}}, SeedStroke());
    any = true;
  }
  return any;
}

/// Shades the region that is predicted stable, and draws its boundary and the line of no growth.
void DrawPrediction(Chart& chart, Picture& picture) {
  const PicturePoint corner = chart.At(kPredicted, 0);
  picture.shapes.emplace_back(
      RectangleShape{{kMarginPlot.x, kMarginPlot.y, corner.x - kMarginPlot.x, kMarginPlot.height},
                     Rgb{235, 243, 250},
                     {},
                     {}});
  chart.DrawCurve({{kLeast, 0}, {kMost, 0}}, {{120, 120, 120}, 1, {}});
  chart.DrawCurve({{kPredicted, -10}, {kPredicted, 10}}, {kBlack, 1.6, {6, 4}});
}

/// Numbers of cells that are shown, and that were measured otherwise than predicted.
struct MarginCounts {
  std::size_t shown = 0;
  std::size_t unstable = 0;
  std::size_t undecided = 0;
};

/// Draws a mark for each cell that has a prediction and a measurement.
MarginCounts DrawCells(const Results& results, const Chart& chart, Picture& picture) {
  MarginCounts counts;
  for (const auto& numbered : results.records) {
    const CellRecord& record = numbered.second;
    const CaseResult& result = record.outcome.result;
    if (!record.outcome.predicted || result.fault) continue;
    const double ratio = record.outcome.predicted->stiffness / record.outcome.predicted->critical;
    const double growth = ShownGrowth(result);
    if (std::isnan(ratio) || std::isnan(growth)) continue;
    if (record.outcome.predicted->is_stable()) {
      counts.unstable += result.verdict == Verdict::kUnstable ? 1U : 0U;
      counts.undecided += result.verdict == Verdict::kUndecided ? 1U : 0U;
    }
    ++counts.shown;
    const PicturePoint at = chart.At(std::clamp(ratio, kLeast, kMost), ClampGrowth(growth));
    const CellFacts facts = FactsOf(record);
    const MarginMark mark = MarginMarkOf(result.verdict);
    picture.shapes.emplace_back(MarkerShape{
        at, mark.kind, kSize, mark.colour,
        LineOf(record, facts) + ": " + NameOf(result.verdict) + ", " + TableNumber(ratio) +
            " of the boundary, growth " + TableNumber(result.metrics.growth) + "/s"});
  }
  return counts;
}

void DrawMarginLegend(bool several_seeds, Picture& picture) {
  double y = 90;
  for (const auto& [verdict, text] : {std::pair(Verdict::kStable, "measured stable"),
                                      std::pair(Verdict::kUnstable, "measured unstable"),
                                      std::pair(Verdict::kUndecided, "undecided")}) {
    const MarginMark mark = MarginMarkOf(verdict);
    DrawLegendMarker(picture, {668, y}, mark.kind, kSize, mark.colour, text);
    y += 22;
  }
  DrawLegendLine(picture, {668, y}, {kBlack, 1.6, {6, 4}}, "0.9 of the boundary");
  if (several_seeds) {
    DrawLegendLine(picture, {668, 222}, SeedStroke(), "least to greatest of a case's seeds");
  }
  picture.shapes.emplace_back(LabelShape{{668, 186},
                                         "Boundary: exact in free space,",
                                         12,
                                         TextAnchor::kStart,
                                         {80, 80, 80},
                                         false,
                                         false});
  picture.shapes.emplace_back(LabelShape{{668, 204},
                                         "b / delay where there is contact.",
                                         12,
                                         TextAnchor::kStart,
                                         {80, 80, 80},
                                         false,
                                         false});
}

}  // namespace

Picture MarginPictureOf(const Results& results, const std::string& name) {
  Picture picture{
      name, "Prediction and measurement: growth over the distance to the boundary", 940, 490, {}};
  picture.shapes.emplace_back(LabelShape{{kMarginPlot.x, 26},
                                         "Prediction and measurement of " + results.header.sweep,
                                         15,
                                         TextAnchor::kStart,
                                         kBlack,
                                         true,
                                         false});
  Chart chart(picture, kMarginPlot,
              {"stiffness divided by the boundary's (values beyond are drawn at the edges)", kLeast,
               kMost, true},
              {"growth, 1/s", -1.05 * kMostGrowth, 1.05 * kMostGrowth, false});
  chart.DrawGrid();
  DrawPrediction(chart, picture);
  const bool several_seeds = DrawSeedSpans(results, chart);
  const MarginCounts counts = DrawCells(results, chart, picture);
  chart.DrawAxes();
  picture.shapes.emplace_back(
      LabelShape{{kMarginPlot.x, 47},
                 std::to_string(counts.shown) +
                     " cells; shaded: predicted stable, below 0.9 of the boundary; " +
                     std::to_string(counts.unstable) + " of those measured unstable, " +
                     std::to_string(counts.undecided) + " undecided",
                 12,
                 TextAnchor::kStart,
                 {80, 80, 80},
                 false,
                 false});
  DrawMarginLegend(several_seeds, picture);
  return picture;
}

}  // namespace tandem
