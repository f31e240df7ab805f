#pragma once

#include <string>

#include "engine/base/result.h"

namespace tandem {

/// Opens the device that `asked` names, reads it a thousand times a second for `seconds`, and
/// writes no force. Returns what it saw as one JSON object: what the device says it can, times of
/// reading and writing, how far the handle moved and turned, reads that failed and why, buttons. A
/// person who has the device in hand sends it along with a report.
Result<std::string> TryDevice(const std::string& asked, double seconds);

}  // namespace tandem
