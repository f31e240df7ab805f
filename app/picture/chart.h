#pragma once

#include <string>
#include <vector>

#include "app/picture/picture.h"

namespace tandem {

/// An axis of a chart. Its label includes the unit. `from` and `to` differ; both are above 0 where
/// the axis is logarithmic.
struct Axis {
  std::string label;
  double from = 0;
  double to = 1;
  bool logarithmic = false;

  /// Returns where a value lies: 0 at `from`, 1 at `to`.
  double Share(double value) const;
};

struct Tick {
  double value = 0;
  std::string text;  // empty: a small tick
};

/// Returns ticks at round values, 1, 2 and 5 of each decade or fewer, at most about `most` of them
/// with text. None: the axis has no finite positive length, or is logarithmic and does not begin
/// above 0.
std::vector<Tick> TicksOf(const Axis& axis, int most);

/// Plots into a box of a picture.
class Chart {
 public:
  /// `box` is the plot itself. Texts of ticks and labels stand outside it.
  Chart(Picture& picture, const PictureBox& box, Axis x, Axis y);

  PicturePoint At(double x, double y) const;
  const PictureBox& box() const { return box_; }

  /// Draws faint lines at the ticks with text. Called before the curves.
  void DrawGrid();
  /// Draws frame, ticks, texts and labels. Called after the curves. Without `x_texts` the
  /// horizontal axis has ticks alone.
  void DrawAxes(bool x_texts = true);
  /// Draws a line through points in the axes' units, clipped to the box and broken at values that
  /// are not finite. `casing` draws a wider white line below it.
  void DrawCurve(const std::vector<PicturePoint>& points, const Stroke& stroke,
                 bool casing = false);

 private:
  Picture& picture_;
  PictureBox box_;
  Axis x_;
  Axis y_;
};

/// pixels from the place of a legend's line to its text
inline constexpr double kLegendText = 38;

/// Draws a line of a legend: a sample of the stroke, or a marker in its size, with a text to its
/// right.
void DrawLegendLine(Picture& picture, const PicturePoint& at, const Stroke& stroke,
                    const std::string& text);
void DrawLegendMarker(Picture& picture, const PicturePoint& at, MarkerKind kind, double size,
                      Rgb colour, const std::string& text);

/// Formats a number in the fewest digits, at most six: 0.05, 20, 1000, 2e+06.
std::string ShortNumber(double value);

}  // namespace tandem
