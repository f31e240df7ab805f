#pragma once

#include <cstdio>
#include <string>

#include "app/option_checks.h"
#include "engine/geometry/triangle_mesh.h"

namespace tandem {

/// What to say besides when a mesh file is refused that was read at `scale` metres per file unit:
/// a file that is tens of metres long because nobody gave its unit is in millimetres, as a rule.
inline std::string UnitHint(const TriangleMesh& mesh, double scale) {
  constexpr double kOddlyLong = 10;  // m
  const double longest = BoundsOf(mesh).size().maxCoeff();
  if (scale != kDefaultScale || !(longest > kOddlyLong)) return {};
  char text[120];
  std::snprintf(text, sizeof text,
                "; read in metres it is %.4g m long: in millimetres? --scale 0.001", longest);
  return text;
}

}  // namespace tandem
