#include "app/device/drivers/forcedimension/dhd.h"

#include <cstdlib>
#include <vector>

namespace tandem::driver {

std::string LoadDhd(const std::string& file, Dhd& dhd) {
  std::vector<std::string> files{file};
  if (file.empty()) {
    if (const char* folder = std::getenv("FDSDK")) {  // NOLINT(concurrency-mt-unsafe)
      files.push_back(std::string(folder) + "/lib/release/lin-x86_64-gcc/libdrd.so");
      files.push_back(std::string(folder) + "/lib/libdrd.so");
    }
    // libdrd contains all of libdhd, which is therefore not loaded
    files.insert(files.end(), {"libdrd.so", "libdrd.so.3"});
  }
  VendorLibrary library;
  if (!library.Load(files)) return library.why();
  library.Take(dhd.GetDeviceCount, "dhdGetDeviceCount");
  library.Take(dhd.OpenID, "dhdOpenID");
  library.Take(dhd.Close, "dhdClose");
  library.Take(dhd.Stop, "dhdStop");
  library.Take(dhd.GetSystemType, "dhdGetSystemType");
  library.Take(dhd.GetSystemName, "dhdGetSystemName");
  library.Take(dhd.HasWrist, "dhdHasWrist");
  library.Take(dhd.HasActiveWrist, "dhdHasActiveWrist");
  library.Take(dhd.EnableForce, "dhdEnableForce");
  library.Take(dhd.EnableExpertMode, "dhdEnableExpertMode");
  library.Take(dhd.SetWatchdog, "dhdSetWatchdog");
  library.Take(dhd.SetMaxForce, "dhdSetMaxForce");
  library.Take(dhd.SetMaxTorque, "dhdSetMaxTorque");
  library.Take(dhd.SetBrakes, "dhdSetBrakes");
  library.Take(dhd.SetGravityCompensation, "dhdSetGravityCompensation");
  library.Take(dhd.GetPositionAndOrientationFrame, "dhdGetPositionAndOrientationFrame");
  library.Take(dhd.GetLinearVelocity, "dhdGetLinearVelocity");
  library.Take(dhd.GetAngularVelocityRad, "dhdGetAngularVelocityRad");
  library.Take(dhd.SetForceAndTorque, "dhdSetForceAndTorque");
  library.Take(dhd.GetButtonMask, "dhdGetButtonMask");
  library.Take(dhd.GetStatus, "dhdGetStatus");
  library.Take(dhd.ErrorGetLast, "dhdErrorGetLast");
  library.Take(dhd.ErrorGetLastStr, "dhdErrorGetLastStr");
  library.Take(dhd.drdOpenID, "drdOpenID");
  library.Take(dhd.drdIsInitialized, "drdIsInitialized");
  library.Take(dhd.drdAutoInit, "drdAutoInit");
  library.Take(dhd.drdStop, "drdStop");
  if (library.missing().empty()) return {};
  return "the library has no function " + library.missing() + ": install version 3.17 of the SDK";
}

}  // namespace tandem::driver
