#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "app/picture/picture.h"
#include "engine/base/result.h"
#include "engine/geometry/mesh/triangle_mesh.h"
#include "engine/voxel/map/voxmap.h"

namespace tandem {

/// A row of the paper's table 1 (section 7), of a scene of plain contact.
struct SceneTimes {
  std::size_t moving_triangles = 0;
  /// Triangles of the fixed bodies; where none is fixed, of all but the first hand's body.
  std::size_t fixed_triangles = 0;
  std::size_t points = 0;  // points of the moving body
  VoxelCounts voxels;      // voxels of the fixed bodies
  double voxelize_s = 0;   // the fixed bodies' voxels and the moving body's points
  double load_s = 0;       // meshes read, voxels mapped from a file, points made
};

/// Measures a row. Lengths in m. The voxels go to a temporary file on the way.
Result<SceneTimes> TimeScene(const std::string& scene, double voxel_size, double point_spacing);

/// Returns the mesh of all fixed bodies of a scene, where they stand.
Result<TriangleMesh> FixedMeshOf(const std::string& scene);

struct VoxelizeTime {
  double voxel_size = 0;  // m
  double seconds = 0;     // least of two runs
  std::size_t voxels = 0;
};
Result<VoxelizeTime> TimeVoxelize(const TriangleMesh& mesh, double voxel_size);

/// seconds = factor * (voxel size / 1 mm)^exponent.
struct PowerLaw {
  double factor = 0;
  double exponent = 0;
};
/// Fits the law by least squares of the logarithms. Needs at least two times, of different voxel
/// sizes.
PowerLaw FitPowerLaw(const std::vector<VoxelizeTime>& times);

/// Draws the paper's figure 10, with the law as a line.
Picture Figure10Picture(const std::vector<VoxelizeTime>& times, const PowerLaw& law);

}  // namespace tandem
