#pragma once

#include <cstddef>
#include <stop_token>

#include "engine/base/peak_memory.h"
#include "engine/base/result.h"
#include "engine/base/spatial.h"
#include "engine/contact/field/field_pair.h"
#include "engine/contact/pair/contact_kind.h"
#include "engine/field/build/field_builder.h"
#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// The parameters of a surface besides its mesh, and bounds on its building.
struct SurfaceOptions {
  double voxel_size = 0.001;  // m
  /// Flatness of feature polygons: voxels either side of their plane.
  double flatness_voxels = FlatnessVoxels(ContactModel::kRefined);
  double spacing_voxels = 1;  // longest part of an edge
  /// Band and range of the distance field, as in FieldOptions.
  double band_voxels = FieldOptions{}.band;
  double range_voxels = FieldOptions{}.range;
  std::size_t max_memory_bytes = PeakMemory();
  /// When it is asked to stop, the builder soon ends with an error.
  std::stop_token stop = {};
};

/// Builds the surface of a mesh where it stands in W, in a body's frame that stands at X_WB. The
/// bytes are the same for any number of threads. Errors are as of BuildField(), in one line.
Result<BodySurface> BuildSurface(const TriangleMesh& mesh_W, const Pose& X_WB,
                                 const SurfaceOptions& options);

/// Places a field and features of a mesh in a body's frame.
BodySurface SurfaceInBody(DistanceField field, BodyFeatures features, const TriangleMesh& mesh_W,
                          const Pose& X_WB);

}  // namespace tandem
