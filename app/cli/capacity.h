#pragma once

#include "engine/realtime/frame_helpers.h"
#include "engine/world/step_inputs.h"
#include "engine/world/world_model.h"

namespace tandem {

/// Of a frame of 1 ms, s: for the tests of points, and for the exact look at those that may be in
/// contact; the rest is for forces, the step, the network and the machine's own doings. Whichever
/// needs more takes it from the other.
inline constexpr double kTestBudget = 300e-6;
inline constexpr double kLookBudget = 200e-6;
inline constexpr double kFrameBudget = kTestBudget + kLookBudget;

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
