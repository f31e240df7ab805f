#pragma once

#include "app/device/tandem_device.h"

namespace tandem {

/// Hands that a script moves (engine/haptics/hand_script.h). `scripted` feels and gives way; `none`
/// is exactly where the script wants it.
extern const TandemDriver kScriptedDriver;
extern const TandemDriver kPassiveDriver;

}  // namespace tandem
