#pragma once

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>

#include "engine/geometry/triangle_mesh.h"

namespace tandem {

/// Whether a file's kind has a unit of its own: that of 3MF files.
inline bool HasOwnUnit(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return ending == ".3mf";
}

/// What to say of a mesh file that was read at `scale` metres per file unit, if anybody gave that:
/// a file that is tens of metres long because nobody gave its unit is in millimetres, as a rule.
/// Empty: nothing.
inline std::string UnitHint(const std::filesystem::path& file, const TriangleMesh& mesh,
                            std::optional<double> scale) {
  constexpr double kOddlyLong = 10;  // m
  const double longest = BoundsOf(mesh).size().maxCoeff();
  if (scale || HasOwnUnit(file) || !(longest > kOddlyLong)) return {};
  char text[120];
  std::snprintf(text, sizeof text,
                "read in metres it is %.4g m long: in millimetres? --scale 0.001", longest);
  return text;
}

/// The same behind what was said already.
inline std::string AndUnitHint(const std::filesystem::path& file, const TriangleMesh& mesh,
                               std::optional<double> scale) {
  const std::string hint = UnitHint(file, mesh, scale);
  return hint.empty() ? hint : "; " + hint;
}

/// Of --scale.
inline constexpr const char* kScaleHelp =
    "metres per file unit; default: as a 3MF file declares, else 1";

}  // namespace tandem
