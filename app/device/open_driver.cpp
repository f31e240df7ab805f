#include "app/device/open_driver.h"

#include <algorithm>
#include <array>

#include "app/device/driver_library.h"
#include "app/device/drivers/recorded/recorded.h"
#include "app/device/drivers/scripted/scripted.h"

namespace tandem {
namespace {

// drivers that use the engine's libraries and so are part of the program
const std::array<const TandemDriver*, 3>& BuiltIn() {
  static const std::array drivers{&kScriptedDriver, &kPassiveDriver, &kRecordedDriver};
  return drivers;
}

}  // namespace

std::vector<std::string> DriverNames() {
  std::vector<std::string> names;
  for (const TandemDriver* driver : BuiltIn()) names.emplace_back(driver->name);
  for (const DriverFile& found : FindDrivers()) {
    if (std::ranges::find(names, found.name) == names.end()) names.push_back(found.name);
  }
  std::ranges::sort(names);
  return names;
}

Result<const TandemDriver*> DriverNamed(const std::string& name) {
  for (const TandemDriver* driver : BuiltIn()) {
    if (name == driver->name) return driver;
  }
  for (const DriverFile& found : FindDrivers()) {
    if (name != found.name) continue;
    if (!found.refused.empty()) return Error{found.refused};
    return DriverLibrary::Load(found.file);
  }
  std::string known;
  for (const std::string& one : DriverNames()) known += " " + one;
  return Error{"there is no driver '" + name + "'; the drivers are" + known};
}

Result<std::unique_ptr<DriverDevice>> OpenDriver(const std::string& requested, const Pose& X_WB0) {
  const std::size_t colon = requested.find(':');
  const Result<const TandemDriver*> driver = DriverNamed(requested.substr(0, colon));
  if (!driver) return driver.error();
  return DriverDevice::Open(**driver, colon == std::string::npos ? "" : requested.substr(colon + 1),
                            X_WB0);
}

}  // namespace tandem
