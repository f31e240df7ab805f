#pragma once

#include <array>
#include <string>
#include <string_view>

#include "engine/geometry/formats/affine34.h"

namespace tandem {

/// A placing of an object or a constellation of an AMF file.
struct AmfInstance {
  std::string object;
  std::array<double, 3> delta{};
  std::array<double, 3> angle{};  // about x, y, z, in that order
  std::array<double, 3> scale{1, 1, 1};
};

/// Tells whether an element of an instance is one number of its placing.
bool IsPlaceOfAmf(std::string_view element);

/// Takes that number: a move, a turn, a size, a mirror.
void TakePlaceOfAmf(std::string_view element, double number, AmfInstance& instance);

/// Returns the placing. `of_slic3r`: its angles are radians of six digits, in place of degrees.
Affine34 PlacingOf(const AmfInstance& instance, bool of_slic3r);

}  // namespace tandem
