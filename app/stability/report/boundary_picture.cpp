#include "app/stability/report/boundary_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "app/picture/chart.h"
#include "app/stability/report/cell_facts.h"

namespace tandem {

namespace {

constexpr double kBoundaryWidth = 940;
constexpr PictureBox kBoundaryPlot{84, 64, 560, 360};
constexpr double kRoom = 1.25;  // factor by which the axes exceed what is shown
constexpr double kDotSize = 7;

// distinguishable without telling red from green: after Okabe and Ito
constexpr std::array<Rgb, 6> kKinds{
    {{0, 114, 178}, {213, 94, 0}, {0, 158, 115}, {204, 121, 167}, {230, 159, 0}, {0, 0, 0}}};

constexpr double kLegendX = 668;
constexpr double kLegendSize = 12;
constexpr double kLineStep = 15;
constexpr double kKindStep = 22;
// width of the widest letters in names, share of the text's size
constexpr double kLetterWidth = 0.55;

/// Splits a kind at its commas into lines that fit beside the plot.
std::vector<std::string> LegendLines(const std::string& kind) {
  constexpr auto kMostLetters = static_cast<std::size_t>((kBoundaryWidth - kLegendX - kLegendText) /
                                                         (kLetterWidth * kLegendSize));
  std::vector<std::string> lines{""};
  for (std::size_t from = 0; from < kind.size();) {
    const std::size_t comma = kind.find(", ", from);
    const std::size_t to = comma == std::string::npos ? kind.size() : comma + 2;
    const std::string part = kind.substr(from, to - from);
    if (!lines.back().empty() && lines.back().size() + part.size() > kMostLetters)
      lines.emplace_back();
    lines.back() += part;
    from = to;
  }
  return lines;
}

/// Draws a kind's line or lines of the legend. Returns where the next kind goes.
PicturePoint DrawKind(Picture& picture, PicturePoint at, Rgb colour, const std::string& kind) {
  const std::vector<std::string> lines = LegendLines(kind);
  DrawLegendMarker(picture, at, MarkerKind::kDot, kDotSize, colour, lines.front());
  for (std::size_t i = 1; i < lines.size(); ++i) {
    at.y += kLineStep;
    picture.shapes.emplace_back(LabelShape{{at.x + kLegendText, at.y},
                                           lines[i],
                                           kLegendSize,
                                           TextAnchor::kStart,
                                           {40, 40, 40},
                                           false,
                                           false});
  }
  return {at.x, at.y + kKindStep};
}

}  // namespace

Picture BoundaryPictureOf(const std::vector<BoundaryMark>& marks, const std::string& name) {
  const std::string title = "Stiffness at which motion begins to grow";
  Picture picture{name, title + ", measured and exact, over the delay", kBoundaryWidth, 490, {}};
  picture.shapes.emplace_back(
      LabelShape{{kBoundaryPlot.x, 26}, title, 15, TextAnchor::kStart, kBlack, true, false});
  picture.shapes.emplace_back(
      LabelShape{{kBoundaryPlot.x, 47},
                 "line: through the exact values; dot: measured by bisection",
                 12,
                 TextAnchor::kStart,
                 {80, 80, 80},
                 false,
                 false});
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  double shortest = kInfinite, longest = 0, softest = kInfinite, firmest = 0;
  std::map<std::string, std::vector<BoundaryMark>> kinds;
  for (const BoundaryMark& mark : marks) {
    kinds[mark.kind].push_back(mark);
    shortest = std::min(shortest, 1e3 * mark.delay_s);
    longest = std::max(longest, 1e3 * mark.delay_s);
    for (const double stiffness : {mark.exact, mark.measured}) {
      if (!(stiffness > 0) || !std::isfinite(stiffness)) continue;
      softest = std::min(softest, stiffness);
      firmest = std::max(firmest, stiffness);
    }
  }
  if (!(longest > 0) || !(firmest > 0)) return picture;
  Chart chart(picture, kBoundaryPlot,
              {"one-way delay, ms", shortest / kRoom, longest * kRoom, true},
              {"stiffness of all links of a user, N/m", softest / kRoom, firmest * kRoom, true});
  chart.DrawGrid();
  PicturePoint at{kLegendX, 90};
  std::size_t number = 0;
  for (auto& [kind, of_kind] : kinds) {
    const Rgb colour = kKinds[number++ % kKinds.size()];
    std::ranges::stable_sort(of_kind, {}, &BoundaryMark::delay_s);
    std::vector<PicturePoint> exact;
    for (const BoundaryMark& mark : of_kind) exact.push_back({1e3 * mark.delay_s, mark.exact});
    chart.DrawCurve(exact, {colour, 1.6, {}});
    for (const BoundaryMark& mark : of_kind) {
      if (!(mark.measured > 0) || !std::isfinite(mark.measured)) continue;
      picture.shapes.emplace_back(MarkerShape{
          chart.At(1e3 * mark.delay_s, mark.measured), MarkerKind::kDot, kDotSize, colour,
          kind + ", " + TableNumber(1e3 * mark.delay_s) + " ms: measured " +
              TableNumber(mark.measured) + " N/m, exact " + TableNumber(mark.exact) + " N/m"});
    }
    at = DrawKind(picture, at, colour, kind);
  }
  picture.height = std::max(picture.height, at.y);
  chart.DrawAxes();
  return picture;
}

}  // namespace tandem
