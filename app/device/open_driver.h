#pragma once

#include <memory>
#include <string>
#include <vector>

#include "app/device/driver_device.h"
#include "app/device/tandem_device.h"
#include "engine/base/result.h"

namespace tandem {

/// The names of all drivers that there are: those built into this program, and those of the folders
/// (DriverFolders). None is loaded.
std::vector<std::string> DriverNames();

/// A driver by its name, loaded where it is in a file. Errors: there is none, or its file is
/// unsound.
Result<const TandemDriver*> DriverNamed(const std::string& name);

/// Opens the device that `asked` names, as NAME[:OPTIONS]. `X_WB0`: where the part stands that the
/// hand is to hold. May take seconds.
Result<std::unique_ptr<DriverDevice>> OpenDriver(const std::string& asked, const Pose& X_WB0);

}  // namespace tandem
