#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.h"
#include "engine/geometry/triangle_mesh.h"

namespace tandem {

/// A pair of meshes in one frame (mm), and where their poses are sought.
struct PosedPair {
  std::string fixed_file;
  std::string moving_file;
  const TriangleMesh* fixed = nullptr;
  const TriangleMesh* moving = nullptr;  // where it stands at first it touches nothing
  Vec3 push = Vec3::Zero();              // unit; the way to where it has much contact
  double spread = 1;                     // how far the ways to the near poses lie round it
  Vec3 out = Vec3::Zero();               // from there on everything is far
  double voxel = 1;
  std::uint64_t seed = 1;
};

/// X takes the moving mesh from where it stands at first.
struct SeededPose {
  std::string kind;     // assembled, near_1_2, near_3_8, far
  Pose X;               // mm
  double distance = 0;  // mm, by samples; below 0: pushed on that far after it touched
};

/// So many of each kind: seated, that is pushed along `push` next to unturned and on by up to half
/// a voxel from where it touches; 1 to 2 voxels away and 3 to 8 voxels away, turned by up to 0.3
/// degrees; far.
std::vector<SeededPose> SeededPoses(const PosedPair& pair, int of_each);

/// As CSV that `tandem contact` reads, translations in mm.
std::optional<Error> WritePoses(const PosedPair& pair, const std::vector<SeededPose>& poses,
                                const std::filesystem::path& file);

}  // namespace tandem
