#pragma once

#include <cstdint>
#include <vector>

#include "engine/base/result.h"
#include "engine/geometry/triangle_mesh.h"
#include "engine/voxel/voxel.h"

namespace tandem {

/// A body's surface as points that are tested against other bodies' voxmaps (paper §2.1, §3.2): one
/// at the centre of every surface voxel of its own voxelization, with a unit normal that points
/// into the body. Where both sides of a thin sheet lie in one voxel there is a point for each.
/// Grouped by chunk. Coordinates in the body's frame B; read-only once built.
struct Pointshell {
  /// Points [first, first + count), from one chunk.
  struct Chunk {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    Vec3 p_BC = Vec3::Zero();  // centre of the points' box, m
    double radius = 0;         // of the ball round it that holds them all, m
  };

  double spacing = 0;             // voxel size of its voxelization, m
  std::vector<float> x, y, z;     // p_BP, m
  std::vector<float> nx, ny, nz;  // inward unit normals
  std::vector<Label> labels;      // of their voxels
  std::vector<Chunk> chunks;
  double radius = 0;  // largest distance of a point from Bo, m

  std::size_t size() const noexcept { return x.size(); }
  Vec3 point(std::size_t i) const { return Vec3(x[i], y[i], z[i]); }
  Label label(std::size_t i) const { return labels[i]; }
  Vec3 normal(std::size_t i) const { return Vec3(nx[i], ny[i], nz[i]); }
};

struct PointshellOptions {
  double spacing = 0.001;   // m
  double inward_shift = 0;  // along the normals, m; negative shifts outward
  std::size_t max_memory_bytes = std::size_t{8} << 30U;
};

/// Makes the points of a mesh that stands in W, in the frame B that stands at X_WB then.
Result<Pointshell> MakePointshell(const TriangleMesh& mesh_W, const Pose& X_WB,
                                  const PointshellOptions& options);

/// A hash of the points and normals, in their (Morton) order.
std::uint64_t Digest(const Pointshell& points);

}  // namespace tandem
