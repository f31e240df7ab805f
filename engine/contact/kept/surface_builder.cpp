#include "engine/contact/kept/surface_builder.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "engine/contact/features/feature_points.h"
#include "engine/geometry/mesh/mesh_facing.h"

namespace tandem {

Result<BodySurface> BuildSurface(const TriangleMesh& mesh_W, const Pose& X_WB,
                                 const SurfaceOptions& options) {
  Result<DistanceField> field = BuildField(mesh_W, {.voxel_size = options.voxel_size,
                                                    .band = options.band_voxels,
                                                    .range = options.range_voxels,
                                                    .max_memory_bytes = options.max_memory_bytes,
                                                    .stop = options.stop});
  if (!field) return field.error();
  const TriangleMesh facing_W = OrientOutward(mesh_W, FindFacing(mesh_W, MeshSides(mesh_W)));
  const std::vector<FeaturePoint> points = FindFeaturePoints(
      facing_W, FindFeatures(facing_W, options.flatness_voxels * options.voxel_size),
      options.voxel_size, options.spacing_voxels);
  const Pose X_VW{Quat::Identity(), -field->p_WVo() / options.voxel_size};
  return SurfaceInBody(std::move(*field), BodyFeatures(points, X_VW), mesh_W, X_WB);
}

BodySurface SurfaceInBody(DistanceField field, BodyFeatures features, const TriangleMesh& mesh_W,
                          const Pose& X_WB) {
  BodySurface surface;
  surface.X_BV = X_WB.Inverse() * Pose{Quat::Identity(), field.p_WVo()};
  surface.field = std::move(field);
  surface.features = std::move(features);
  for (const Vec3& vertex_W : mesh_W.vertices) {
    surface.radius = std::max(surface.radius, (vertex_W - X_WB.p).norm());
  }
  return surface;
}

}  // namespace tandem
