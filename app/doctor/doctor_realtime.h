#pragma once

#include "app/doctor/findings.h"

namespace tandem {

/// Checks what this machine grants a loop of a millisecond, and says what grants more. It looks at
/// priority, locked memory, cores, their clock and the lateness of a timer.
void CheckRealtime(Findings& findings);

}  // namespace tandem
