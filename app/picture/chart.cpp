#include "app/picture/chart.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

namespace tandem {

namespace {

constexpr Rgb kGrid{226, 226, 226};
constexpr Rgb kText{40, 40, 40};
constexpr double kTextSize = 12;
constexpr double kLegendSample = 30;  // pixels

bool IsWithin(const Axis& axis, double value) {
  const double share = axis.Share(value);
  return share > -1e-9 && share < 1 + 1e-9;
}

std::vector<Tick> LogTicks(const Axis& axis, int most) {
  const double decades = std::log10(axis.to / axis.from);
  // all decades have texts at 1, 2 and 5, or at 1 alone
  const bool all = 3 * decades <= most;
  const bool one = decades <= most;
  std::vector<Tick> ticks;
  const int first = static_cast<int>(std::floor(std::log10(axis.from)));
  const int last = static_cast<int>(std::ceil(std::log10(axis.to)));
  for (int decade = first; decade <= last; ++decade) {
    for (int digit = 1; digit <= 9; ++digit) {
      const double value = digit * std::pow(10.0, decade);
      if (!IsWithin(axis, value)) continue;
      const bool text =
          (digit == 1 && (one || decade % 2 == 0)) || (all && (digit == 2 || digit == 5));
      ticks.push_back({value, text ? ShortNumber(value) : ""});
    }
  }
  return ticks;
}

std::vector<Tick> LinearTicks(const Axis& axis, int most) {
  const double least = (axis.to - axis.from) / std::max(1, most);
  const double decade = std::pow(10.0, std::floor(std::log10(least)));
  double step = 10 * decade;
  for (const double digit : {1.0, 2.0, 5.0}) {
    if (digit * decade >= least * (1 - 1e-9)) {
      step = digit * decade;
      break;
    }
  }
  std::vector<Tick> ticks;
  // counted, since far from zero adding the step may not change the value
  const double first = std::ceil(axis.from / step - 1e-9);
  for (int tick = 0; tick <= std::max(1, most) + 1; ++tick) {
    const double i = first + tick;
    if (!(i * step <= axis.to + 1e-9 * step)) break;
    const double value = i == 0 ? 0.0 : i * step;
    ticks.push_back({value, ShortNumber(value)});
  }
  return ticks;
}

// Liang and Barsky: clips the segment from a to b to the box; false: nothing is left
bool Clip(const PictureBox& box, PicturePoint& a, PicturePoint& b) {
  double from = 0;
  double to = 1;
  const double dx = b.x - a.x;
  const double dy = b.y - a.y;
  const std::array<std::pair<double, double>, 4> edges{
      {{-dx, a.x - box.x}, {dx, box.right() - a.x}, {-dy, a.y - box.y}, {dy, box.bottom() - a.y}}};
  for (const auto& [way, room] : edges) {
    if (way == 0 && room < 0) return false;
    if (way == 0) continue;
    const double at = room / way;
    if (way < 0) from = std::max(from, at);
    if (way > 0) to = std::min(to, at);
  }
  if (from > to) return false;
  b = {a.x + to * dx, a.y + to * dy};
  a = {a.x + from * dx, a.y + from * dy};
  return true;
}

}  // namespace

std::string ShortNumber(double value) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return text.data();
}

double Axis::Share(double value) const {
  if (logarithmic) return std::log(value / from) / std::log(to / from);
  return (value - from) / (to - from);
}

std::vector<Tick> TicksOf(const Axis& axis, int most) {
  const bool has_length = axis.to > axis.from && std::isfinite(axis.to - axis.from);
  if (!has_length || (axis.logarithmic && !(axis.from > 0))) return {};
  return axis.logarithmic ? LogTicks(axis, most) : LinearTicks(axis, most);
}

Chart::Chart(Picture& picture, const PictureBox& box, Axis x, Axis y)
    : picture_(picture), box_(box), x_(std::move(x)), y_(std::move(y)) {}

PicturePoint Chart::At(double x, double y) const {
  return {box_.x + box_.width * x_.Share(x), box_.bottom() - box_.height * y_.Share(y)};
}

void Chart::DrawGrid() {
  const auto draw = [this](PicturePoint a, PicturePoint b) {
    picture_.shapes.emplace_back(PolylineShape{{a, b}, {kGrid, 1, {}}});
  };
  for (const Tick& tick : TicksOf(x_, static_cast<int>(box_.width / 55))) {
    const double x = box_.x + box_.width * x_.Share(tick.value);
    if (!tick.text.empty()) draw({x, box_.y}, {x, box_.bottom()});
  }
  for (const Tick& tick : TicksOf(y_, static_cast<int>(box_.height / 22))) {
    const double y = box_.bottom() - box_.height * y_.Share(tick.value);
    if (!tick.text.empty()) draw({box_.x, y}, {box_.right(), y});
  }
}

void Chart::DrawAxes(bool x_texts) {
  const Stroke thin{kText, 1, {}};
  picture_.shapes.emplace_back(RectangleShape{box_, {}, thin, {}});
  double widest = 0;
  for (const Tick& tick : TicksOf(x_, static_cast<int>(box_.width / 55))) {
    const double x = box_.x + box_.width * x_.Share(tick.value);
    const double length = tick.text.empty() ? 3 : 6;
    picture_.shapes.emplace_back(
        PolylineShape{{{x, box_.bottom()}, {x, box_.bottom() + length}}, thin});
    if (tick.text.empty() || !x_texts) continue;
    picture_.shapes.emplace_back(LabelShape{
        {x, box_.bottom() + 19}, tick.text, kTextSize, TextAnchor::kMiddle, kText, false, false});
  }
  for (const Tick& tick : TicksOf(y_, static_cast<int>(box_.height / 22))) {
    const double y = box_.bottom() - box_.height * y_.Share(tick.value);
    const double length = tick.text.empty() ? 3 : 6;
    picture_.shapes.emplace_back(PolylineShape{{{box_.x - length, y}, {box_.x, y}}, thin});
    if (tick.text.empty()) continue;
    const LabelShape text{
        {box_.x - 9, y + 4}, tick.text, kTextSize, TextAnchor::kEnd, kText, false, false};
    widest = std::max(widest, BoundsOf(text).width);
    picture_.shapes.emplace_back(text);
  }
  if (x_texts) {
    picture_.shapes.emplace_back(LabelShape{{box_.x + 0.5 * box_.width, box_.bottom() + 40},
                                            x_.label,
                                            kTextSize + 1,
                                            TextAnchor::kMiddle,
                                            kText,
                                            false,
                                            false});
  }
  picture_.shapes.emplace_back(LabelShape{{box_.x - 18 - widest, box_.y + 0.5 * box_.height},
                                          y_.label,
                                          kTextSize + 1,
                                          TextAnchor::kMiddle,
                                          kText,
                                          false,
                                          true});
}

void Chart::DrawCurve(const std::vector<PicturePoint>& points, const Stroke& stroke, bool casing) {
  std::vector<PolylineShape> pieces;
  const auto good = [](const PicturePoint& point) {
    return std::isfinite(point.x) && std::isfinite(point.y);
  };
  bool on = false;  // true: the last piece ends where the next segment begins
  for (std::size_t i = 1; i < points.size(); ++i) {
    PicturePoint a = At(points[i - 1].x, points[i - 1].y);
    PicturePoint b = At(points[i].x, points[i].y);
    const PicturePoint whole = b;
    if (!good(a) || !good(b) || !Clip(box_, a, b)) {
      on = false;
      continue;
    }
    if (!on) pieces.push_back({{a}, stroke});
    pieces.back().points.push_back(b);
    on = b.x == whole.x && b.y == whole.y;
  }
  for (const PolylineShape& piece : pieces) {
    if (casing) {
      picture_.shapes.emplace_back(PolylineShape{piece.points, {kWhite, stroke.width + 2, {}}});
    }
  }
  for (PolylineShape& piece : pieces) picture_.shapes.emplace_back(std::move(piece));
}

void DrawLegendLine(Picture& picture, const PicturePoint& at, const Stroke& stroke,
                    const std::string& text) {
  picture.shapes.emplace_back(
      PolylineShape{{{at.x, at.y - 4}, {at.x + kLegendSample, at.y - 4}}, stroke});
  picture.shapes.emplace_back(LabelShape{
      {at.x + kLegendText, at.y}, text, kTextSize, TextAnchor::kStart, kText, false, false});
}

void DrawLegendMarker(Picture& picture, const PicturePoint& at, MarkerKind kind, double size,
                      Rgb colour, const std::string& text) {
  picture.shapes.emplace_back(
      MarkerShape{{at.x + 0.5 * kLegendSample, at.y - 4}, kind, size, colour, {}});
  picture.shapes.emplace_back(LabelShape{
      {at.x + kLegendText, at.y}, text, kTextSize, TextAnchor::kStart, kText, false, false});
}

}  // namespace tandem
