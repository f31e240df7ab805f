#pragma once

#include <cstddef>
#include <stop_token>

#include "engine/base/peak_memory.h"
#include "engine/base/result.h"
#include "engine/field/query/distance_field.h"
#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

struct FieldOptions {
  double voxel_size = 0.001;  // m
  double band =
      0.65;  // width in which readings are within the error bound, voxels; kLeastBand to kMostBand
  /// Distance up to which places of the free side have a reading, voxels: from the band to
  /// kMostRange. Beyond 1.5 memory and time grow with it.
  double range = DistanceField::kLeastRange;
  static constexpr double kMostRange = 32;
  static constexpr double kLeastBand = 0.1;
  static constexpr double kMostBand = 1;
  std::size_t max_memory_bytes = PeakMemory();
  /// When it is asked to stop, the builder soon ends with an error.
  std::stop_token stop = {};
};

/// Builds the distance field of a mesh where it stands in W, with the union of its bodies as the
/// solid. It works in parallel; the bits are the same for any number of threads. Errors, in one
/// line, are those of Voxelize(): no triangles, a voxel size that is not above 0, a need beyond
/// max_memory_bytes. Another is steps that would need more than 2 GiB.
Result<DistanceField> BuildField(const TriangleMesh& mesh_W, const FieldOptions& options);

}  // namespace tandem
