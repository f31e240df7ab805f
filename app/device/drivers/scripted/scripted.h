#pragma once

#include "app/device/tandem_device.h"

namespace tandem {

/// Hands that a script moves (engine/haptics/hand_script.h). `scripted` feels forces and yields;
/// `none` is exactly where the script puts it.
extern const TandemDriver kScriptedDriver;
extern const TandemDriver kPassiveDriver;

}  // namespace tandem
