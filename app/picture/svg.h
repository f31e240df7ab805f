#pragma once

#include <string>

#include "app/picture/picture.h"

namespace tandem {

enum class SvgPlace : std::uint8_t {
  kFile,   // document of its own
  kInHtml  // element of a page, without the SVG namespace, which looks like an address
};

/// Writes the picture as SVG. Text stays text, and hints become titles. Coordinates are rounded to
/// 0.01 pixels.
std::string SvgOf(const Picture& picture, SvgPlace place);

}  // namespace tandem
