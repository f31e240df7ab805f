#pragma once

#include <cstdint>
#include <functional>

#include "engine/world/world.h"

namespace tandem {

/// Puts the first body at NaN while `look` runs. The engine would not survive a frame of it.
void ShowNoNumber(World& world, const std::function<void()>& look);

/// Moves bodies before a peer's frame, as the fault of the session says: the one in hand, or those
/// that follow other peers. `held`: index of the body in hand; -1: none.
void ShiftBodies(std::uint32_t seq, int held, const StepInputs& inputs, World& world) noexcept;

}  // namespace tandem
