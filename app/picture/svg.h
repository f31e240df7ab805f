#pragma once

#include <string>

#include "app/picture/picture.h"

namespace tandem {

enum class SvgPlace : std::uint8_t {
  kFile,   // a document of its own
  kInHtml  // an element of a page: without the name of SVG's language, which looks like an address
};

/// The picture as SVG: text stays text, hints are titles. Coordinates are given to a hundredth of a
/// pixel.
std::string SvgOf(const Picture& picture, SvgPlace place);

}  // namespace tandem
