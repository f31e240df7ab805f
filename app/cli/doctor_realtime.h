#pragma once

#include "app/cli/findings.h"

namespace tandem {

/// What this machine grants a loop of a millisecond, and what grants more: priority, locked memory,
/// cores, their clock, and how late a timer is.
void CheckRealtime(Findings& findings);

}  // namespace tandem
