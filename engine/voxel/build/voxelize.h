#pragma once

#include <functional>
#include <optional>
#include <stop_token>

#include "engine/base/peak_memory.h"
#include "engine/base/result.h"
#include "engine/geometry/mesh/facets.h"
#include "engine/geometry/mesh/triangle_mesh.h"
#include "engine/voxel/map/voxmap.h"

namespace tandem {

struct VoxelizeOptions {
  double voxel_size = 0.001;  // m
  int range = kDefaultRange;  // range of the distance fields, voxels
  int bits = 4;               // bits of a mark: 2 (range 1), 4 (to 13) or 8 (to 252)
  /// Flatness of feature-free polygons, voxels either side of their plane (paper §4.1).
  double flatness_voxels = 0.5;
  std::size_t max_memory_bytes = PeakMemory();
  /// Gets the share that is done, rising from 0 to 1, from one thread at a time; may be empty.
  std::function<void(double)> progress = {};
  /// When it is asked to stop, voxelization soon ends with an error.
  std::stop_token stop = {};
};

/// Returns an upper estimate of the peak memory of voxelizing, from the mesh's area and box.
std::size_t EstimateVoxelizeBytes(const TriangleMesh& mesh_W, const VoxelizeOptions& options);

/// Returns why a mesh cannot be voxelized at the options' voxel size within their memory, and a
/// voxel size that would do; nothing if it can.
std::optional<Error> VoxelSizeFault(const TriangleMesh& mesh_W, const VoxelizeOptions& options);

/// Returns why Voxelize() refuses a mesh and options; nothing if it does not.
std::optional<Error> VoxelizeFault(const TriangleMesh& mesh_W, const VoxelizeOptions& options);

/// Voxelizes a mesh where it stands in W: exact conservative surface, distance field, and interior.
/// The interior comes from counted crossings, for open bodies from the winding number (paper §2.1,
/// §3; decision 0003). It works in parallel; the bits are the same for any number of threads.
/// Errors, in one line: no triangles, a voxel size that is not above 0, a need beyond
/// max_memory_bytes.
Result<Voxmap> Voxelize(const TriangleMesh& mesh_W, const VoxelizeOptions& options);

/// Does the same with features and sides of the mesh that were found before, at the options'
/// flatness.
Result<Voxmap> Voxelize(const TriangleMesh& mesh_W, const MeshSides& sides,
                        const Features& features, const VoxelizeOptions& options);

/// Voxelizes in as many parts as the options' memory requires: maps of some layers of hyperchunks
/// each, with the whole box, in rising order. An error of `take` ends it. A map's chunk-level field
/// covers its own voxels alone.
std::optional<Error> VoxelizeInParts(
    const TriangleMesh& mesh_W, const VoxelizeOptions& options,
    const std::function<std::optional<Error>(const Voxmap& part)>& take);

/// Returns the voxel size of `--voxel auto`: a two-hundredth of the longest side, m.
double AutoVoxelSize(const TriangleMesh& mesh);

}  // namespace tandem
