#pragma once

#include "engine/realtime/worker_pool.h"
#include "engine/world/step_inputs.h"
#include "engine/world/world_model.h"

namespace tandem {

/// The part of a frame of 1 ms that the haptic thread's work may take, s. The machine has the rest.
inline constexpr double kFrameBudget = 800e-6;

/// The work that fits into a frame.
struct FrameCapacity {
  double tests = kDefaultCapacity;  // nCapacity (paper §5)
  double query_price = kDefaultQueryPrice;
};

/// Measures the capacity of this machine for a scene (paper §5): how many points the calling thread
/// and its workers, if any, can test in `seconds`. The tests are spread over the body with the most
/// points, as in a frame. It also measures the price of an exact query, in such tests. Takes some
/// tens of milliseconds. Call it before the loop begins.
FrameCapacity MeasureCapacity(const WorldModel& world, double seconds,
                              WorkerPool* workers = nullptr);

}  // namespace tandem
