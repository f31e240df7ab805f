#pragma once

#include "engine/realtime/frame_helpers.h"
#include "engine/world/step_inputs.h"
#include "engine/world/world_model.h"

namespace tandem {

/// Of a frame of 1 ms, s: for all that the haptic thread does in it; the rest is for the machine's
/// own doings.
inline constexpr double kFrameBudget = 800e-6;

/// What fits into a frame.
struct FrameCapacity {
  double tests = kDefaultCapacity;  // nCapacity (paper §5)
  double look_price = kDefaultLookPrice;
};

/// The capacity of this machine for a scene (paper §5): how many points the calling thread and its
/// helpers, if any, can test in `seconds`, as they are tested in a frame, here and there along the
/// largest pointshell; and how many of these tests an exact look takes as long as. Takes about 40
/// ms. Call it before the loop begins.
FrameCapacity MeasureCapacity(const WorldModel& world, double seconds,
                              FrameHelpers* helpers = nullptr);

}  // namespace tandem
