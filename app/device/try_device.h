#pragma once

#include <string>

#include "engine/base/result.h"

namespace tandem {

/// Opens the device `requested`, reads it 1000 times a second for `seconds`, and writes no force.
/// Returns one JSON object for reports about the device: its capabilities, times of reading and
/// writing, how far the handle moved and turned, failed reads with reasons, and buttons.
Result<std::string> TryDevice(const std::string& requested, double seconds);

}  // namespace tandem
