#include "app/bench/measure/removal_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <utility>

#include "app/picture/chart.h"

namespace tandem {

namespace {

constexpr double kWidth = 720;
constexpr double kHeight = 360;
constexpr PictureBox kPlot{70, 20, 630, 280};
constexpr std::size_t kColumns = 630;
constexpr Rgb kBlue{0, 114, 178};
constexpr Rgb kOrange{213, 94, 0};

Picture Blank(std::string name, std::string title) {
  Picture picture{.name = std::move(name),
                  .title = std::move(title),
                  .width = kWidth,
                  .height = kHeight,
                  .shapes = {}};
  picture.shapes.emplace_back(
      RectangleShape{.box = {0, 0, kWidth, kHeight}, .fill = kWhite, .edge = {}, .hint = {}});
  return picture;
}

/// Returns the least round number that is not below the value.
double RoundedUp(double value) {
  if (value <= 0) return 1;
  const double decade = std::pow(10, std::floor(std::log10(value)));
  for (const double step : {1.0, 2.0, 5.0, 10.0}) {
    if (step * decade >= value) return step * decade;
  }
  return 10 * decade;
}

/// Returns for each pixel of the time axis the largest value of its frames.
std::vector<PicturePoint> MostOf(const RemovalTrace& trace,
                                 const std::function<double(const RemovalTrace::Frame&)>& value) {
  std::vector<PicturePoint> points;
  const std::size_t count = trace.frames.size();
  for (std::size_t column = 0; column < kColumns; ++column) {
    const std::size_t first = column * count / kColumns;
    const std::size_t last = (column + 1) * count / kColumns;
    double most = 0;
    for (std::size_t i = first; i < last; ++i) most = std::max(most, value(trace.frames[i]));
    if (last > first) points.push_back({1e-3 * static_cast<double>(first), most});
  }
  return points;
}

double Highest(const std::vector<PicturePoint>& points) {
  double highest = 0;
  for (const PicturePoint& point : points) highest = std::max(highest, point.y);
  return highest;
}

/// Returns the share of values above each time of the axis.
std::vector<PicturePoint> SharesAbove(const Histogram& times) {
  constexpr int kSteps = 400;
  std::vector<PicturePoint> points;
  for (int i = 0; i < kSteps; ++i) {
    // shares from 1 down to 1e-5
    const double above = std::pow(10, -5.0 * i / kSteps);
    points.push_back({1e-3 * static_cast<double>(times.Quantile(1 - above)), 100 * above});
  }
  return points;
}

}  // namespace

std::vector<Picture> RemovalPictures(const RemovalTrace& trace, const Histogram& at_1khz,
                                     const Histogram& least) {
  std::vector<Picture> pictures;
  {
    Picture picture = Blank("removal_times", "Share of frames that took longer, in percent");
    const double most = 1e-3 * static_cast<double>(std::max(at_1khz.max(), least.max()));
    Chart chart(
        picture, kPlot,
        {.label = "processor time of a frame, µs", .from = 0, .to = RoundedUp(most)},
        {.label = "frames that took longer, %", .from = 1e-3, .to = 100, .logarithmic = true});
    chart.DrawGrid();
    chart.DrawCurve(SharesAbove(at_1khz), {.colour = kOrange, .width = 1.5, .dashes = {}});
    if (least.count() > 0) {
      chart.DrawCurve(SharesAbove(least), {.colour = kBlue, .width = 1.5, .dashes = {}});
    }
    chart.DrawAxes();
    DrawLegendLine(picture, {480, 40}, {.colour = kOrange, .width = 1.5, .dashes = {}}, "at 1 kHz");
    if (least.count() > 0) {
      DrawLegendLine(picture, {480, 60}, {.colour = kBlue, .width = 1.5, .dashes = {}},
                     "least of all passes");
    }
    pictures.push_back(std::move(picture));
  }
  const double end = std::max(1e-3 * static_cast<double>(trace.frames.size()), 1e-3);
  {
    Picture picture = Blank("removal_contacts", "Points in contact, over the time");
    const auto contacts = MostOf(trace, [](const RemovalTrace::Frame& frame) {
      return static_cast<double>(frame.contacts);
    });
    Chart chart(picture, kPlot, {.label = "time, s", .from = 0, .to = end},
                {.label = "points in contact", .from = 0, .to = RoundedUp(Highest(contacts))});
    chart.DrawGrid();
    chart.DrawCurve(contacts, {.colour = kBlue, .width = 1.5, .dashes = {}});
    chart.DrawAxes();
    pictures.push_back(std::move(picture));
  }
  {
    Picture picture = Blank("removal_force", "Force of contact and of the hand, over the time");
    const auto contact = MostOf(trace, [](const RemovalTrace::Frame& frame) {
      return static_cast<double>(frame.contact_N);
    });
    const auto hand = MostOf(trace, [](const RemovalTrace::Frame& frame) {
      return static_cast<double>(frame.hand_N);
    });
    Chart chart(picture, kPlot, {.label = "time, s", .from = 0, .to = end},
                {.label = "force, N",
                 .from = 0,
                 .to = RoundedUp(std::max(Highest(contact), Highest(hand)))});
    chart.DrawGrid();
    chart.DrawCurve(contact, {.colour = kOrange, .width = 1.5, .dashes = {}});
    chart.DrawCurve(hand, {.colour = kBlue, .width = 1.5, .dashes = {}});
    chart.DrawAxes();
    DrawLegendLine(picture, {540, 40}, {.colour = kOrange, .width = 1.5, .dashes = {}}, "contact");
    DrawLegendLine(picture, {540, 60}, {.colour = kBlue, .width = 1.5, .dashes = {}}, "hand");
    pictures.push_back(std::move(picture));
  }
  return pictures;
}

}  // namespace tandem
