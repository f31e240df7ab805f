#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/base/result.h"
#include "engine/base/spatial.h"

namespace tandem {

/// One row of a poses file: the moving file's frame, first where the fixed one's is, turned about
/// its own origin and then shifted: X = T(t) R(axis, angle).
struct FilePose {
  std::size_t row = 0;  // from 0, over the file's rows
  std::string fixed;
  std::string moving;
  std::string kind;  // as the column of that name says, if there is one
  Pose X_WM;         // translation in file units
};

/// What a poses file is about: pairs of mesh files, or bodies of a scene, which needs no column
/// `fixed`.
enum class PosesOf { kPairs, kSceneBodies };

/// Reads CSV with a header line that names at least fixed, moving, tx, ty, tz, ax, ay, az,
/// angle_deg. An error names the file, the line and what was expected there.
Result<std::vector<FilePose>> ReadPosesFile(const std::filesystem::path& file,
                                            PosesOf of = PosesOf::kPairs);

}  // namespace tandem
