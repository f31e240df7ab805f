#include "app/stability/wrapped_legend.h"

#include <vector>

#include "app/picture/chart.h"

namespace tandem {

namespace {

constexpr double kLegendSize = 12;
constexpr double kLineStep = 15;
constexpr double kKindStep = 22;
// of the widest letters that names are of, as a share of the text's size
constexpr double kLetterWidth = 0.55;

/// The parts of a text, between commas, in lines of at most so many letters.
std::vector<std::string> LegendLines(const std::string& text, std::size_t most) {
  std::vector<std::string> lines{""};
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t comma = text.find(", ", from);
    const std::size_t to = comma == std::string::npos ? text.size() : comma + 2;
    const std::string part = text.substr(from, to - from);
    if (!lines.back().empty() && lines.back().size() + part.size() > most) lines.emplace_back();
    lines.back() += part;
    from = to;
  }
  return lines;
}

}  // namespace

PicturePoint DrawWrappedLegend(Picture& picture, PicturePoint at, double right, double marker_size,
                               Rgb colour, const std::string& text) {
  const auto most =
      static_cast<std::size_t>((right - at.x - kLegendText) / (kLetterWidth * kLegendSize));
  const std::vector<std::string> lines = LegendLines(text, most);
  DrawLegendMarker(picture, at, MarkerKind::kDot, marker_size, colour, lines.front());
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

}  // namespace tandem
