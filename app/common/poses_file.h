#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.h"
#include "engine/base/spatial.h"

namespace tandem {

/// One row of a poses file. The moving file's frame is first where the fixed one's is. It is turned
/// about its own origin and then shifted: X = T(t) R(axis, angle).
struct FilePose {
  std::size_t row = 0;  // index over the file's rows, from 0
  std::string fixed;
  std::string moving;
  std::string kind;           // value of the column of that name, if there is one
  Pose X_WM;                  // translation in file units
  std::optional<double> t_s;  // value of the column of that name, if there is one
};

/// Reads CSV with a header line that names at least moving, tx, ty, tz, ax, ay, az, angle_deg. In a
/// file without the column `fixed`, poses are those of bodies in a scene, and `fixed` is empty. An
/// error names the file, the line and what was expected there.
Result<std::vector<FilePose>> ReadPosesFile(const std::filesystem::path& file);

/// Returns a time of a poses file as text, with the fewest digits that keep a microsecond.
std::string SecondsText(double t_s);

}  // namespace tandem
