#pragma once

#include <string>
#include <vector>

#include "app/picture/picture.h"

namespace tandem {

/// One axis of a chart: its label has the unit. From and to are not equal; above zero where
/// logarithmic.
struct Axis {
  std::string label;
  double from = 0;
  double to = 1;
  bool logarithmic = false;

  /// Where a value is, 0 at `from`, 1 at `to`.
  double Share(double value) const;
};

struct Tick {
  double value = 0;
  std::string text;  // empty: a small tick
};

/// At round values, at most about `most` with text: 1, 2 and 5 of each decade, or fewer. None on an
/// axis without a finite length above 0, nor on a logarithmic one that does not begin above 0.
std::vector<Tick> TicksOf(const Axis& axis, int most);

/// Plots into a box of a picture.
class Chart {
 public:
  /// The box is that of the plot itself; ticks' texts and labels stand outside of it.
  Chart(Picture& picture, const PictureBox& box, Axis x, Axis y);

  PicturePoint At(double x, double y) const;
  const PictureBox& box() const { return box_; }

  /// Faint lines at the ticks with text; below what is plotted.
  void DrawGrid();
  /// Frame, ticks, texts and labels; above it. Without `x_texts` the horizontal axis has ticks
  /// alone.
  void DrawAxes(bool x_texts = true);
  /// Through points of the axes' units, cut at the box; broken where a value is no number.
  /// `casing`: on a white line that is wider.
  void DrawCurve(const std::vector<PicturePoint>& points, const Stroke& stroke,
                 bool casing = false);

 private:
  Picture& picture_;
  PictureBox box_;
  Axis x_;
  Axis y_;
};

/// From the place of a legend's line to its text, pixels.
inline constexpr double kLegendText = 38;

/// A line of a legend: a sample of the stroke, or a marker of its size in the picture, and a text
/// at its right.
void DrawLegendLine(Picture& picture, const PicturePoint& at, const Stroke& stroke,
                    const std::string& text);
void DrawLegendMarker(Picture& picture, const PicturePoint& at, MarkerKind kind, double size,
                      Rgb colour, const std::string& text);

/// 0.05, 20, 1000, 2e+05: as few digits as there are.
std::string ShortNumber(double value);

}  // namespace tandem
