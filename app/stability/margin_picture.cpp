#include "app/stability/margin_picture.h"

#include <algorithm>
#include <cmath>

#include "app/picture/chart.h"
#include "app/stability/cell_facts.h"
#include "app/stability/map_picture.h"

namespace tandem {

namespace {

constexpr PictureBox kMarginPlot{84, 64, 560, 360};
constexpr double kLeast = 0.02;  // stiffness over the boundary's
constexpr double kMost = 20;
constexpr double kPredicted = 0.9;
constexpr Rgb kStable{0, 90, 160};
constexpr Rgb kUnstable{200, 60, 20};

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
              {"stiffness over that of the boundary (what is beyond stands at the edges)", kLeast,
               kMost, true},
              {"growth, 1/s", -1.05 * kMostGrowth, 1.05 * kMostGrowth, false});
  chart.DrawGrid();
  // what is predicted stable
  const PicturePoint corner = chart.At(kPredicted, 0);
  picture.shapes.emplace_back(
      RectangleShape{{kMarginPlot.x, kMarginPlot.y, corner.x - kMarginPlot.x, kMarginPlot.height},
                     Rgb{235, 243, 250},
                     {},
                     {}});
  chart.DrawCurve({{kLeast, 0}, {kMost, 0}}, {{120, 120, 120}, 1, {}});
  chart.DrawCurve({{kPredicted, -10}, {kPredicted, 10}}, {kBlack, 1.6, {6, 4}});
  std::size_t shown = 0;
  std::size_t unexpected = 0;
  for (const auto& numbered : results.records) {
    const CellRecord& record = numbered.second;
    const CaseResult& result = record.outcome.result;
    if (!record.outcome.predicted || result.fault) continue;
    const double ratio = record.outcome.predicted->stiffness / record.outcome.predicted->critical;
    const double growth = result.metrics.blew_up ? kMostGrowth : result.metrics.growth;
    if (std::isnan(ratio) || std::isnan(growth)) continue;
    const bool stable = result.verdict == Verdict::kStable;
    unexpected += record.outcome.predicted->is_stable() && !stable ? 1U : 0U;
    ++shown;
    const PicturePoint at =
        chart.At(std::clamp(ratio, kLeast, kMost), std::clamp(growth, -kMostGrowth, kMostGrowth));
    const CellFacts facts = FactsOf(record);
    picture.shapes.emplace_back(MarkerShape{
        at, stable ? MarkerKind::kDot : MarkerKind::kCross, stable ? 4.0 : 6.5,
        stable ? kStable : kUnstable,
        LineOf(record, facts) + ": " + NameOf(result.verdict) + ", " + TableNumber(ratio) +
            " of the boundary, growth " + TableNumber(result.metrics.growth) + "/s"});
  }
  chart.DrawAxes();
  picture.shapes.emplace_back(LabelShape{
      {kMarginPlot.x, 47},
      std::to_string(shown) + " cells; shaded: predicted stable, below 0.9 of the boundary; " +
          std::to_string(unexpected) + " of those not measured so",
      12,
      TextAnchor::kStart,
      {80, 80, 80},
      false,
      false});
  DrawLegendMarker(picture, {668, 90}, MarkerKind::kDot, kStable, "measured stable");
  DrawLegendMarker(picture, {668, 112}, MarkerKind::kCross, kUnstable, "unstable or undecided");
  DrawLegendLine(picture, {668, 134}, {kBlack, 1.6, {6, 4}}, "0.9 of the boundary");
  picture.shapes.emplace_back(LabelShape{{668, 164},
                                         "Boundary: exact in free space,",
                                         12,
                                         TextAnchor::kStart,
                                         {80, 80, 80},
                                         false,
                                         false});
  picture.shapes.emplace_back(LabelShape{{668, 182},
                                         "b / delay where there is contact.",
                                         12,
                                         TextAnchor::kStart,
                                         {80, 80, 80},
                                         false,
                                         false});
  return picture;
}

}  // namespace tandem
