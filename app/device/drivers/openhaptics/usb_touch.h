#pragma once

#include <filesystem>
#include <string>

namespace tandem::driver {

/// A Touch at USB, as the kernel shows it. Devices at Ethernet or FireWire are not seen so.
struct UsbTouch {
  bool is_plugged = false;
  std::string refused;  // file of the device that this user may not read and write; empty: none
  std::string mend;     // the line that gives the right
};

/// Looks for one below `root`; opens nothing.
UsbTouch FindUsbTouch(const std::filesystem::path& root = "/");

}  // namespace tandem::driver
