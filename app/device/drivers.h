#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/base/result.h"
#include "engine/haptics/device.h"

namespace tandem {

/// What `tandem-device` can have in hand, a line each: how it is asked for, and what it is.
struct DriverName {
  const char* name;
  const char* what;
};
const std::vector<DriverName>& Drivers();

/// Opens the device that `asked` names, as NAME[:OPTIONS]. `X_WB0`: where the body is at first that
/// the hand is to hold. May take seconds.
Result<std::unique_ptr<Device>> OpenDriver(const std::string& asked, const Pose& X_WB0);

}  // namespace tandem
