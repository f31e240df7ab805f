#pragma once

#include <functional>

#include "engine/world/world.h"

namespace tandem {

/// Puts the first body at NaN while `look` runs. The engine would not survive a frame of it.
void ShowNoNumber(World& world, const std::function<void()>& look);

}  // namespace tandem
