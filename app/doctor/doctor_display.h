#pragma once

#include "app/doctor/findings.h"

namespace tandem {

/// Checks whether a window can open: the display, Qt's platform, and OpenGL. `tandem-view` looks,
/// since this program has neither Qt nor OpenGL. A machine without a display can still run peers,
/// so that nothing found here is bad.
void CheckDisplay(Findings& findings);

}  // namespace tandem
