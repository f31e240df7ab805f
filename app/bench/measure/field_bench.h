#pragma once

#include "engine/base/result.h"
#include "engine/world/world_model.h"

namespace tandem {

/// The price and the error of the distance field of a moving body, at places where contact reads
/// it. The places are in the order of the body's pointshell, each within half a voxel of a point.
struct FieldFigures {
  double field_ns = 0;                // processor time of a value among many
  double field_with_gradient_ns = 0;  // processor time of a value with its gradient
  struct Errors {
    double p50 = 0, p99 = 0, max = 0;
  };
  Errors error_voxels;              // errors against exact triangles, within the band
  double bytes_per_band_voxel = 0;  // for each voxel of the marks' band, so that both compare
  double build_cpu_s = 0;           // processor time on one thread
  double voxelize_cpu_s = 0;        // time for the voxmap beside it, on one thread
};
Result<FieldFigures> MeasureField(const WorldModel& world, std::size_t body, int rounds);

}  // namespace tandem
