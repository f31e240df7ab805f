#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.h"
#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// A pair of meshes in one frame (mm), and the region of their poses.
struct PosedPair {
  std::string fixed_file;
  std::string moving_file;
  const TriangleMesh* fixed = nullptr;
  const TriangleMesh* moving = nullptr;  // in its first pose it touches nothing
  Vec3 push = Vec3::Zero();              // unit; direction to a pose with much contact
  double spread = 1;                     // spread of the directions to the near poses round it
  Vec3 out = Vec3::Zero();               // place from which on all poses are far
  double voxel = 1;
  std::uint64_t seed = 1;
};

/// A pose. X takes the moving mesh from its first pose.
struct SeededPose {
  std::string kind;     // assembled, near_1_2, near_3_8, far
  Pose X;               // mm
  double distance = 0;  // mm, by samples; below 0: pushed on that far after it touched
};

/// Returns `of_each` poses of each kind. Assembled: pushed along `push`, almost unturned, and on by
/// up to half a voxel from where it touches. Near: 1 to 2 voxels away, and 3 to 8 voxels away,
/// turned by up to 0.3 degrees. Far.
std::vector<SeededPose> SeededPoses(const PosedPair& pair, int of_each);

/// Writes them as CSV that `tandem contact` reads, translations in mm.
std::optional<Error> WritePoses(const PosedPair& pair, const std::vector<SeededPose>& poses,
                                const std::filesystem::path& file);

}  // namespace tandem
