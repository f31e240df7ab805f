#include "engine/geometry/formats/amf_instance.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "engine/base/spatial.h"

namespace tandem {

namespace {

/// Returns a turn; `rounding`: quarter turns that the file rounds away.
Mat3 Turn(int axis, double radians, double rounding) {
  // quarter turns are exact, so that placed corners meet
  const double quarter = radians / (std::numbers::pi / 2);
  const bool exact = std::abs(quarter - std::round(quarter)) <= rounding;
  const double c = exact ? std::round(std::cos(radians)) : std::cos(radians);
  const double s = exact ? std::round(std::sin(radians)) : std::sin(radians);
  Mat3 R = Mat3::Identity();
  const int a = (axis + 1) % 3;
  const int b = (axis + 2) % 3;
  R(a, a) = c;
  R(a, b) = -s;
  R(b, a) = s;
  R(b, b) = c;
  return R;
}

}  // namespace

bool IsPlaceOfAmf(std::string_view element) {
  constexpr std::array<std::string_view, 13> kPlaces{
      "deltax", "deltay", "deltaz", "rx",      "ry",      "rz",     "scale",
      "scalex", "scaley", "scalez", "mirrorx", "mirrory", "mirrorz"};
  return std::ranges::count(kPlaces, element) > 0;
}

void TakePlaceOfAmf(std::string_view element, double number, AmfInstance& instance) {
  if (element == "scale") {
    for (double& scale : instance.scale) scale *= number;
    return;
  }
  const auto axis = static_cast<std::size_t>(element.back() - 'x');
  if (element.starts_with("delta")) {
    instance.delta[axis] = number;
  } else if (element.starts_with('r')) {
    instance.angle[axis] = number;
  } else {
    instance.scale[axis] *= number;
  }
}

Affine34 PlacingOf(const AmfInstance& instance, bool of_slic3r) {
  constexpr double kSixDigits = 1e-5;  // quarter turns
  constexpr double kExact = 1e-12;
  const double unit = of_slic3r ? 1 : std::numbers::pi / 180;
  const auto turn = [&](std::size_t axis) {
    return Turn(static_cast<int>(axis), unit * instance.angle[axis],
                of_slic3r ? kSixDigits : kExact);
  };
  const auto& s = instance.scale;
  Affine34 X;
  X.leftCols<3>() = turn(2) * turn(1) * turn(0) * Vec3(s[0], s[1], s[2]).asDiagonal();
  X.col(3) = Vec3(instance.delta[0], instance.delta[1], instance.delta[2]);
  return X;
}

}  // namespace tandem
