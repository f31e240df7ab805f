#pragma once

#include "engine/realtime/frame_helpers.h"
#include "engine/world/world_model.h"

namespace tandem {

/// Of a frame of 1 ms, s: for the tests of points; the rest is for contacts, the step, the network
/// and the machine's own doings.
inline constexpr double kTestBudget = 300e-6;

/// The nCapacity of this machine for a scene (paper §5): how many points the calling thread and
/// its helpers, if any, can test in `seconds`, as they are tested in a frame, here and there along
/// the largest pointshell. Takes about 20 ms. Call it before the loop begins.
double MeasureCapacity(const WorldModel& world, double seconds, FrameHelpers* helpers = nullptr);

}  // namespace tandem
