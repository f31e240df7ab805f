#pragma once

#include <string>

#include "app/picture/picture.h"

namespace tandem {

/// A legend's marker and its text, broken after commas into lines that end left of `right`. Returns
/// where the next one goes.
PicturePoint DrawWrappedLegend(Picture& picture, PicturePoint at, double right, double marker_size,
                               Rgb colour, const std::string& text);

}  // namespace tandem
