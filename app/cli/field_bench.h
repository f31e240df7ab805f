#pragma once

#include "engine/base/result.h"
#include "engine/world/world_model.h"

namespace tandem {

/// What the distance field of a moving body takes and how true it is, at places where contact asks
/// it: in the order of the body's pointshell, each within half a voxel of a point.
struct FieldFigures {
  double field_ns = 0;                // of a value among many, processor time
  double field_with_gradient_ns = 0;  // of a value and a gradient
  struct Errors {
    double p50 = 0, p99 = 0, max = 0;
  };
  Errors error_voxels;              // against exact triangles, within the band
  double bytes_per_band_voxel = 0;  // of the marks' band, so that both compare
  double build_cpu_s = 0;           // on one thread
  double voxelize_cpu_s = 0;        // of the marks beside it, on one thread
};
Result<FieldFigures> MeasureField(const WorldModel& world, std::size_t body, int rounds);

}  // namespace tandem
