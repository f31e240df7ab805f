#pragma once

#include <memory>
#include <string>
#include <vector>

#include "app/device/driver_device.h"
#include "app/device/tandem_device.h"
#include "engine/base/result.h"

namespace tandem {

/// Returns the names of all drivers: those built into this program and those in DriverFolders().
/// Loads none.
std::vector<std::string> DriverNames();

/// Returns a driver by its name, and loads it where it is in a file. Errors: there is none of that
/// name, or its file is unsound.
Result<const TandemDriver*> DriverNamed(const std::string& name);

/// Opens the device `requested`, given as NAME[:OPTIONS]. `X_WB0`: the pose of the part that the
/// hand is to hold. May take seconds.
Result<std::unique_ptr<DriverDevice>> OpenDriver(const std::string& requested, const Pose& X_WB0);

}  // namespace tandem
