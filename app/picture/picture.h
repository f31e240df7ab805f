#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace tandem {

/// A picture is a list of shapes, each drawn over those before it. SvgOf() (svg.h) writes it, or
/// `tandem-view --paint` paints it. Lengths are in pixels, x to the right, y down.

struct Rgb {
  std::uint8_t r = 0;
  std::uint8_t g = 0;
  std::uint8_t b = 0;

  bool operator==(const Rgb&) const = default;
};

inline constexpr Rgb kBlack{0, 0, 0};
inline constexpr Rgb kWhite{255, 255, 255};

struct PicturePoint {
  double x = 0;
  double y = 0;
};

struct PictureBox {
  double x = 0;  // left
  double y = 0;  // top
  double width = 0;
  double height = 0;

  double right() const { return x + width; }
  double bottom() const { return y + height; }
  bool Overlaps(const PictureBox& other) const {
    return x < other.right() && other.x < right() && y < other.bottom() && other.y < bottom();
  }
};

struct Stroke {
  Rgb colour;
  double width = 1;
  std::vector<double> dashes;  // lengths on, off, on, …; empty: a solid line
};

struct PolylineShape {
  std::vector<PicturePoint> points;
  Stroke stroke;
};

struct RectangleShape {
  PictureBox box;
  std::optional<Rgb> fill;
  std::optional<Stroke> edge;
  std::string hint;  // text shown while the pointer is over the shape
};

enum class MarkerKind : std::uint8_t { kDot, kCross, kRing };

struct MarkerShape {
  PicturePoint at;
  MarkerKind kind = MarkerKind::kDot;
  double size = 5;  // width
  Rgb colour;
  std::string hint;
};

enum class TextAnchor : std::uint8_t { kStart, kMiddle, kEnd };

struct LabelShape {
  PicturePoint at;  // on the text's base line
  std::string text;
  double size = 12;
  TextAnchor anchor = TextAnchor::kStart;
  Rgb colour;
  bool bold = false;
  bool upwards = false;  // true: the text is rotated to read upwards
};

using PictureShape = std::variant<RectangleShape, PolylineShape, MarkerShape, LabelShape>;

struct Picture {
  std::string name;   // name of its files
  std::string title;  // description for a reader who cannot see the picture
  double width = 0;
  double height = 0;
  std::vector<PictureShape> shapes;
};

/// Estimates the text's bounds for a sans-serif face of usual width.
PictureBox BoundsOf(const LabelShape& label);

}  // namespace tandem
