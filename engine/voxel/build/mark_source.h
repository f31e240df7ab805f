#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "engine/base/result.h"
#include "engine/geometry/mesh/facets.h"
#include "engine/geometry/mesh/mesh_facing.h"
#include "engine/voxel/build/inside_rows.h"
#include "engine/voxel/build/mark_planes.h"
#include "engine/voxel/build/surface_bricks.h"
#include "engine/voxel/build/voxelize.h"
#include "engine/voxel/build/voxmap_builder.h"

namespace tandem {

/// Computes the marks of a mesh hyperchunk by hyperchunk, from bits: the voxels that the surface,
/// its edges and its vertices lie in, and the voxels inside. The bits take a tenth of the memory of
/// the marks. Any number of threads may use it at once.
class MarkSource {
 public:
  /// Makes a source for some layers of hyperchunks. `tell` gets the share that is done, 0 to 1.
  /// Returns an error if the options ask it to stop.
  static Result<std::unique_ptr<MarkSource>> Make(const TriangleMesh& mesh_W,
                                                  const Features& features,
                                                  const MeshFacing& facing,
                                                  const VoxelizeOptions& options,
                                                  const HyperchunkLayers& layers,
                                                  const std::function<void(double)>& tell);

  /// Returns the map's box, whose border of one hyperchunk has no marks.
  const HyperchunkBox& box() const noexcept { return box_; }
  /// Returns the kinds of hyperchunks, by cell of the box.
  const std::vector<VoxmapBuilder::Kind>& kinds() const noexcept { return kinds_; }
  /// Returns the hyperchunks with marks, in Morton order.
  const std::vector<GridIndex>& marked() const noexcept { return marked_; }
  /// Returns scratch for Fill(), one for each thread.
  std::unique_ptr<MarkPlanes> MakePlanes() const;
  /// Computes the marks of a hyperchunk.
  void Fill(const GridIndex& place, MarkPlanes& planes) const;
  /// Computes the marks of all hyperchunks in parallel, and hands them to `take` in order, one at a
  /// time. Returns an error if the options ask it to stop.
  std::optional<Error> MakeAll(
      const std::function<void(const GridIndex& place, const MarkPlanes& planes)>& take) const;

 private:
  explicit MarkSource(const VoxelizeOptions& options) : options_(options) {}
  void FindKinds(const HyperchunkLayers& layers, int reach);

  VoxelizeOptions options_;
  std::vector<SurfaceBricks> rounds_;
  std::optional<InsideRows> inside_;
  HyperchunkBox box_;
  std::vector<VoxmapBuilder::Kind> kinds_;
  std::vector<GridIndex> marked_;
};

}  // namespace tandem
