#include "app/picture/picture.h"

#include <algorithm>

namespace tandem {

namespace {

constexpr double kCharacter = 0.56;  // mean width of a character in a sans-serif face, share of the
                                     // text's size
constexpr double kBold = 1.08;
constexpr double kAscent = 0.76;
constexpr double kHeight = 0.98;

// counts the bytes that begin a UTF-8 character
double Characters(const std::string& text) {
  return static_cast<double>(std::ranges::count_if(text, [](char byte) {
    return (static_cast<unsigned char>(byte) & 0xC0U) != 0x80U;
  }));
}

}  // namespace

PictureBox BoundsOf(const LabelShape& label) {
  const double length =
      Characters(label.text) * kCharacter * label.size * (label.bold ? kBold : 1.0);
  double before = 0;
  if (label.anchor == TextAnchor::kMiddle) before = 0.5 * length;
  if (label.anchor == TextAnchor::kEnd) before = length;
  const double rise = kAscent * label.size;
  const double height = kHeight * label.size;
  if (label.upwards) {
    return {label.at.x - rise, label.at.y + before - length, height, length};
  }
  return {label.at.x - before, label.at.y - rise, length, height};
}

}  // namespace tandem
