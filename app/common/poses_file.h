#pragma once

#include <filesystem>
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
  std::string kind;  // value of the column of that name, if there is one
  Pose X_WM;         // translation in file units
};

/// The subject of a poses file: pairs of mesh files, or bodies of a scene, which need no column
/// `fixed`.
enum class PosesOf { kPairs, kSceneBodies };

/// Reads CSV with a header line that names at least fixed, moving, tx, ty, tz, ax, ay, az,
/// angle_deg. An error names the file, the line and what was expected there.
Result<std::vector<FilePose>> ReadPosesFile(const std::filesystem::path& file,
                                            PosesOf of = PosesOf::kPairs);

}  // namespace tandem
