#pragma once

#include <filesystem>
#include <string>

namespace tandem::driver {

/// A Touch at USB, as the kernel reports it. Devices at Ethernet or FireWire are not found in this
/// way.
struct UsbTouch {
  bool is_plugged = false;
  std::string refused;  // file of the device that this user may not read and write; empty: none
  std::string mend;     // command that grants the right
};

/// Looks for a Touch below `root`; opens nothing.
UsbTouch FindUsbTouch(const std::filesystem::path& root = "/");

}  // namespace tandem::driver
