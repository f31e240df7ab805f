#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/geometry/triangle_mesh.h"
#include "engine/voxel/triangle_overlap.h"

namespace tandem {

/// Which voxel centres lie inside a mesh, by the parity of the crossings of grid-aligned rays
/// through the centres, the majority of the three axes.
///
/// Each body (connected component) is counted by itself, so that overlapping bodies are solid where
/// they overlap; a closed body that is turned inside out and lies within another's box is a cavity
/// and counts against. Whether a ray crosses a triangle is decided in whole numbers by a rule that
/// gives every point of a closed surface's shadow to exactly one of the triangles that share it, so
/// no ray slips through an edge. Where a mesh is really open, rays leak; the majority of three
/// mends single leaks.
class RayParity {
 public:
  RayParity(const TriangleMesh& mesh_W, const std::vector<SnappedTriangle>& triangles);

  /// Adds 1 to `votes[i]` for each axis along which the centre of voxel i is inside; the voxels are
  /// those of the cube of `side` voxels a side from `first`, x fastest.
  void AddVotes(const GridIndex& first, std::int32_t side, std::vector<std::uint8_t>& votes) const;
  /// Whether the centre of one voxel is inside along at least two axes.
  bool Inside(const GridIndex& voxel) const;

  /// Share of the rays that cross the surface an odd number of times, over all axes: 0 for closed
  /// meshes.
  double leaking_share() const { return leaking_share_; }

 private:
  /// The places (voxel sizes from W's origin) where the ray of a column goes in and out by turns.
  std::span<const double> Toggles(std::size_t axis, std::int32_t u, std::int32_t v) const;

  struct Columns {
    std::int32_t u0 = 0;
    std::int32_t v0 = 0;
    std::int32_t nu = 0;
    std::int32_t nv = 0;
    std::vector<std::uint32_t> first;  // nu * nv + 1 entries
    std::vector<double> toggles;
  };
  std::array<Columns, 3> columns_;
  double leaking_share_ = 0;
};

}  // namespace tandem
