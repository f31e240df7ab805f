#include "app/stability/report/map_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "app/picture/chart.h"

namespace tandem {

namespace {

constexpr double kWidth = 940;
constexpr double kHeight = 560;
constexpr PictureBox kMapPlot{84, 64, 560, 430};
constexpr PictureBox kColours{668, 84, 18, 150};
constexpr double kLegendTop = 276;
constexpr double kLegendStep = 21;
constexpr double kWidestTile = 0.2;  // half width in ln
constexpr Rgb kGrey{190, 190, 190};
constexpr Rgb kTileEdge{200, 200, 200};  // makes a white tile visible on white

// from -kMostGrowth to kMostGrowth with equal lightness on both sides: ColorBrewer's RdBu without
// its darkest ends, on which black marks would not be visible
constexpr std::array<Rgb, 9> kColourSteps{{{67, 147, 195},
                                           {115, 176, 212},
                                           {163, 205, 227},
                                           {209, 229, 240},
                                           {255, 255, 255},
                                           {253, 219, 199},
                                           {248, 183, 152},
                                           {238, 144, 115},
                                           {222, 104, 84}}};

Stroke StrokeOf(MapLineKind kind) {
  switch (kind) {
    case MapLineKind::kBoundary:
      return {kBlack, 2.6, {}};
    case MapLineKind::kPassive:
      return {{0, 120, 84}, 2, {8, 4}};
    case MapLineKind::kAnyDelay:
      return {{118, 42, 131}, 2, {2, 3}};
    case MapLineKind::kLaw:
      return {{0, 60, 160}, 2.6, {}};
    case MapLineKind::kLinearCalm:
      return {{205, 120, 0}, 2.2, {}};
    case MapLineKind::kLinearFirm:
      return {{205, 120, 0}, 2.2, {10, 4, 2, 4}};
  }
  return {};
}

/// Returns each value's tile: its ends are midway between neighbours, at most `widest` from the
/// value. Distances are measured on `scale`, linear or logarithmic, whose inverse is `back`.
template <class Scale, class Back>
std::vector<std::pair<double, double>> TilesOf(const std::vector<double>& values, double widest,
                                               Scale scale, Back back) {
  std::vector<std::pair<double, double>> tiles;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double at = scale(values[i]);
    double from = at - widest;
    double to = at + widest;
    if (i > 0) from = std::max(from, 0.5 * (at + scale(values[i - 1])));
    if (i + 1 < values.size()) to = std::min(to, 0.5 * (at + scale(values[i + 1])));
    tiles.emplace_back(back(from), back(to));
  }
  return tiles;
}

std::vector<std::pair<double, double>> LogarithmicTiles(const std::vector<double>& values) {
  const auto log = [](double x) {
    return std::log(x);
  };
  const auto exp = [](double x) {
    return std::exp(x);
  };
  return TilesOf(values, kWidestTile, log, exp);
}

/// Returns half the least step between values in rising order.
double HalfStep(const std::vector<double>& values) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < values.size(); ++i)
    least = std::min(least, values[i] - values[i - 1]);
  return std::isfinite(least) ? 0.5 * least : 1.0;
}

std::vector<std::pair<double, double>> EvenTiles(const std::vector<double>& values) {
  const auto same = [](double x) {
    return x;
  };
  return TilesOf(values, HalfStep(values), same, same);
}

std::vector<double> ColumnsOf(const StabilityMap& map) {
  std::set<double> columns;
  for (const MapCell& cell : map.cells) columns.insert(cell.x);
  return {columns.begin(), columns.end()};
}

/// Returns a size at which a long text ends within the picture. The width of a letter is `share` of
/// its height: 0.55, or 0.62 where bold.
double FittingSize(const std::string& text, double most, double share) {
  return std::min(most, (kWidth - kMapPlot.x - 4) / (share * static_cast<double>(text.size() + 1)));
}

void DrawTiles(const StabilityMap& map, const Chart& chart, Picture& picture) {
  std::map<double, std::vector<const MapCell*>> columns;
  for (const MapCell& cell : map.cells) columns[cell.x].push_back(&cell);
  const std::vector<double> at = ColumnsOf(map);
  const auto widths = map.axis == MapAxis::kDelay ? LogarithmicTiles(at) : EvenTiles(at);
  std::size_t number = 0;
  for (auto& column : columns) {
    const std::pair<double, double> width = widths[number++];
    std::vector<const MapCell*>& cells = column.second;
    std::ranges::stable_sort(cells, {}, &MapCell::stiffness);
    std::vector<double> values;
    for (const MapCell* cell : cells) values.push_back(cell->stiffness);
    const auto heights = LogarithmicTiles(values);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const PicturePoint low = chart.At(width.first, heights[i].first);
      const PicturePoint high = chart.At(width.second, heights[i].second);
      picture.shapes.emplace_back(RectangleShape{{low.x, high.y, high.x - low.x, low.y - high.y},
                                                 GrowthColour(cells[i]->growth),
                                                 Stroke{kTileEdge, 0.5, {}},
                                                 cells[i]->hint});
    }
  }
}

MarkerKind MarkOf(Verdict verdict) {
  if (verdict == Verdict::kUnstable) return MarkerKind::kCross;
  return verdict == Verdict::kStable ? MarkerKind::kDot : MarkerKind::kRing;
}

double SizeOf(MarkerKind kind) {
  return kind == MarkerKind::kDot ? 6.0 : 7.0;
}

void DrawMarks(const StabilityMap& map, const Chart& chart, Picture& picture) {
  for (const MapCell& cell : map.cells) {
    const MarkerKind kind = MarkOf(cell.verdict);
    picture.shapes.emplace_back(
        MarkerShape{chart.At(cell.x, cell.stiffness), kind, SizeOf(kind), kBlack, cell.hint});
  }
}

void DrawColours(Picture& picture) {
  constexpr int kSteps = 60;
  for (int i = 0; i < kSteps; ++i) {
    const double growth = kMostGrowth * (1.0 - 2.0 * (i + 0.5) / kSteps);
    const double height = kColours.height / kSteps;
    // each a little longer than its step, so that no gap shows
    picture.shapes.emplace_back(RectangleShape{{kColours.x, kColours.y + i * height, kColours.width,
                                                i + 1 < kSteps ? height + 0.5 : height},
                                               GrowthColour(growth),
                                               {},
                                               {}});
  }
  picture.shapes.emplace_back(RectangleShape{kColours, {}, Stroke{{40, 40, 40}, 1, {}}, {}});
  picture.shapes.emplace_back(LabelShape{{kColours.x, kColours.y - 10},
                                         "growth of the velocities, 1/s",
                                         12,
                                         TextAnchor::kStart,
                                         kBlack,
                                         false,
                                         false});
  const std::array<std::pair<double, const char*>, 5> texts{{{2, "+2 or more, or out of bounds"},
                                                             {1, "+1"},
                                                             {0, "0"},
                                                             {-1, "-1"},
                                                             {-2, "-2 or less, or at rest"}}};
  for (const auto& text : texts) {
    const double y = kColours.y + 0.5 * kColours.height * (1.0 - text.first / kMostGrowth);
    picture.shapes.emplace_back(LabelShape{
        {kColours.right() + 8, y + 4}, text.second, 12, TextAnchor::kStart, kBlack, false, false});
  }
}

/// Returns whether part of a line is in the map: a point, or a step across it.
bool Reaches(const MapLine& line, const MapRange& range) {
  for (std::size_t i = 0; i < line.points.size(); ++i) {
    const PicturePoint& at = line.points[i];
    const PicturePoint& before = line.points[i > 0 ? i - 1 : 0];
    if (!std::isfinite(at.y) || at.x < range.least_x || at.x > range.most_x) continue;
    const double low = std::isfinite(before.y) ? std::min(at.y, before.y) : at.y;
    const double high = std::isfinite(before.y) ? std::max(at.y, before.y) : at.y;
    if (high >= range.softest && low <= range.firmest) return true;
  }
  return false;
}

void DrawLegend(const StabilityMap& map, Picture& picture) {
  PicturePoint at{kColours.x, kLegendTop};
  constexpr std::array<std::pair<Verdict, const char*>, 3> kVerdicts{
      {{Verdict::kStable, "measured stable"},
       {Verdict::kUnstable, "measured unstable"},
       {Verdict::kUndecided, "undecided"}}};
  for (const auto& verdict : kVerdicts) {
    const bool there = std::ranges::any_of(map.cells, [&verdict](const MapCell& cell) {
      return cell.verdict == verdict.first;
    });
    if (!there) continue;
    const MarkerKind kind = MarkOf(verdict.first);
    DrawLegendMarker(picture, at, kind, SizeOf(kind), kBlack, verdict.second);
    at.y += kLegendStep;
  }
  const MapRange range = RangeOf(map);
  for (const MapLine& line : map.lines) {
    if (!Reaches(line, range)) continue;
    DrawLegendLine(picture, at, StrokeOf(line.kind), line.name);
    at.y += kLegendStep;
  }
}

}  // namespace

Rgb GrowthColour(double growth) {
  if (std::isnan(growth)) return kGrey;
  const double share = (std::clamp(growth, -kMostGrowth, kMostGrowth) + kMostGrowth) /
                       (2 * kMostGrowth) * (kColourSteps.size() - 1);
  const auto step = std::min(static_cast<std::size_t>(share), kColourSteps.size() - 2);
  const double part = share - static_cast<double>(step);
  const auto mix = [&](std::uint8_t Rgb::*channel) {
    const double from = kColourSteps[step].*channel;
    const double to = kColourSteps[step + 1].*channel;
    return static_cast<std::uint8_t>(std::lround(from + part * (to - from)));
  };
  return {mix(&Rgb::r), mix(&Rgb::g), mix(&Rgb::b)};
}

MapRange RangeOf(const StabilityMap& map) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  MapRange range{kInfinite, 0, kInfinite, 0};
  for (const MapCell& cell : map.cells) {
    range.least_x = std::min(range.least_x, cell.x);
    range.most_x = std::max(range.most_x, cell.x);
    range.softest = std::min(range.softest, cell.stiffness);
    range.firmest = std::max(range.firmest, cell.stiffness);
  }
  const double margin = std::exp(kWidestTile);
  if (map.axis == MapAxis::kDelay) {
    range.least_x /= margin;
    range.most_x *= margin;
  } else {
    const double half = HalfStep(ColumnsOf(map));
    range.least_x -= half;
    range.most_x += half;
  }
  return {range.least_x, range.most_x, range.softest / margin, range.firmest * margin};
}

Picture PictureOf(const StabilityMap& map) {
  Picture picture{map.name, map.title + ". " + map.note, kWidth, kHeight, {}};
  picture.shapes.emplace_back(LabelShape{{kMapPlot.x, 26},
                                         map.title,
                                         FittingSize(map.title, 15, 0.62),
                                         TextAnchor::kStart,
                                         kBlack,
                                         true,
                                         false});
  picture.shapes.emplace_back(LabelShape{{kMapPlot.x, 47},
                                         map.note,
                                         FittingSize(map.note, 12, 0.55),
                                         TextAnchor::kStart,
                                         {80, 80, 80},
                                         false,
                                         false});
  const MapRange range = RangeOf(map);
  // the chart's axis is in ms or mm
  const bool is_delay = map.axis == MapAxis::kDelay;
  Chart chart(picture, kMapPlot,
              {is_delay ? "one-way delay, ms" : "grasp beside the centre of mass, mm",
               1e3 * range.least_x, 1e3 * range.most_x, is_delay},
              {"stiffness of all links of a user, N/m", range.softest, range.firmest, true});
  StabilityMap shown = map;
  for (MapCell& cell : shown.cells) cell.x *= 1e3;
  chart.DrawGrid();
  DrawTiles(shown, chart, picture);
  for (MapLine& line : shown.lines) {
    for (PicturePoint& point : line.points) point.x *= 1e3;
    chart.DrawCurve(line.points, StrokeOf(line.kind), true);
  }
  DrawMarks(shown, chart, picture);
  chart.DrawAxes();
  DrawColours(picture);
  DrawLegend(map, picture);
  return picture;
}

}  // namespace tandem
