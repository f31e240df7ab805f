#pragma once

#include <functional>
#include <optional>
#include <stop_token>

#include "engine/base/most_memory.h"
#include "engine/base/result.h"
#include "engine/geometry/facets.h"
#include "engine/geometry/triangle_mesh.h"
#include "engine/voxel/voxmap.h"

namespace tandem {

struct VoxelizeOptions {
  double voxel_size = 0.001;  // m
  int range = kDefaultRange;  // of the distance fields, voxels
  int bits = 4;               // of a mark: 2 (range 1), 4 (to 13) or 8 (to 252)
  /// How flat a feature-free polygon must be, in voxels either side of its plane (paper §4.1).
  double flatness_voxels = 0.5;
  std::size_t max_memory_bytes = MostMemory();
  /// Told the share that is done, rising from 0 to 1, by one thread at a time; may be empty.
  std::function<void(double)> progress = {};
  /// Asked to stop, voxelization soon ends with an error.
  std::stop_token stop = {};
};

/// The memory that voxelizing takes at its height, from the mesh's area and box: an estimate on the
/// safe side.
std::size_t EstimateVoxelizeBytes(const TriangleMesh& mesh_W, const VoxelizeOptions& options);

/// Why a mesh cannot be voxelized at the options' voxel size within their memory, and a voxel size
/// that would do; nothing if it can.
std::optional<Error> VoxelSizeFault(const TriangleMesh& mesh_W, const VoxelizeOptions& options);

/// Tells why Voxelize() refuses a mesh and options; nothing if it does not.
std::optional<Error> VoxelizeFault(const TriangleMesh& mesh_W, const VoxelizeOptions& options);

/// Voxelizes a mesh where it stands in W: exact conservative surface, distance field, interior by
/// counted crossings, of open bodies by winding number (paper §2.1, §3; decision 0003). In
/// parallel; the same bits for any number of threads. Refused in one line: no triangles, a voxel
/// size that is not above 0, a need beyond max_memory_bytes.
Result<Voxmap> Voxelize(const TriangleMesh& mesh_W, const VoxelizeOptions& options);

/// With the features and sides of the mesh that were found before, at the options' flatness.
Result<Voxmap> Voxelize(const TriangleMesh& mesh_W, const MeshSides& sides,
                        const Features& features, const VoxelizeOptions& options);

/// The same in as many parts as the options' memory asks for: maps of some layers of hyperchunks
/// each, with the whole box, in rising order. What `take` answers ends it. A map's chunk-level
/// field knows of its own voxels alone.
std::optional<Error> VoxelizeInParts(
    const TriangleMesh& mesh_W, const VoxelizeOptions& options,
    const std::function<std::optional<Error>(const Voxmap& part)>& take);

/// The voxel size that `--voxel auto` stands for: a two-hundredth of the longest side, m.
double AutoVoxelSize(const TriangleMesh& mesh);

}  // namespace tandem
