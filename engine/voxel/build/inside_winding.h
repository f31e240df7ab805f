#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "engine/base/result.h"
#include "engine/geometry/exact/winding_number.h"
#include "engine/geometry/mesh/mesh_facing.h"
#include "engine/voxel/build/surface_bricks.h"

namespace tandem {

/// Adds to `rows` (kBrickRows of them) the voxels of a hyperchunk, other than surface voxels, whose
/// centres an open surface goes round: its winding number there is above kInside.
///
/// Connected voxels of a chunk without surface between them share one evaluation if it is clear;
/// otherwise (in a wide hole) each has its own.
void AddWindingVoxels(const WindingNumber& winding, const Bounds& box_W, double voxel_size,
                      const GridIndex& hyperchunk, const SurfaceBricks::Source* surface,
                      std::uint64_t* rows);

/// Returns the mesh of the open bodies, facing out of the solid.
TriangleMesh OpenBodies(const TriangleMesh& mesh_W, const MeshFacing& facing);

/// Returns why the inside of a mesh's open bodies would cost too much at a voxel size, and a voxel
/// size that would do; nothing if it costs little, or no body is open. A small file can cost
/// minutes: where long triangles turn all ways, each voxel needs all of them. `places`: the number
/// of further places whose winding number is needed.
std::optional<Error> WindingCostFault(const TriangleMesh& mesh_W, const MeshFacing& facing,
                                      double voxel_size, std::size_t places = 0);

/// The winding number above which a voxel is inside. It exceeds one half, so that rounding decides
/// nothing next to a flat sheet, where the number is close to that.
inline constexpr double kInside = 0.55;

}  // namespace tandem
