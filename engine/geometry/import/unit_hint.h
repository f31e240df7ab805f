#pragma once

#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>

#include "engine/geometry/import/declared_unit.h"
#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// Returns a hint on a mesh file that was read at `scale` metres per file unit, if a person gave
/// that scale. A file that is very long in metres, and whose unit nobody gave, is in millimetres as
/// a rule. Empty: no hint.
inline std::string UnitHint(const std::filesystem::path& file, const TriangleMesh& mesh,
                            std::optional<double> scale) {
  constexpr double kOddlyLong = 10;  // m
  const double longest = BoundsOf(mesh).size().maxCoeff();
  if (scale || KindDeclaresUnit(file) || !(longest > kOddlyLong)) return {};
  char text[120];
  std::snprintf(
      text, sizeof text,
      "read in metres, it is %.4g m long: if the file is in millimetres, give --scale 0.001",
      longest);
  return text;
}

/// Returns the same hint, to follow other words in a line.
inline std::string AndUnitHint(const std::filesystem::path& file, const TriangleMesh& mesh,
                               std::optional<double> scale) {
  const std::string hint = UnitHint(file, mesh, scale);
  return hint.empty() ? hint : "; " + hint;
}

/// The help on --scale.
inline constexpr const char* kScaleHelp =
    "metres per file unit; default: as a 3MF, AMF, COLLADA or FBX file declares, else 1";

}  // namespace tandem
