#include "app/device/drivers/openhaptics/usb_touch.h"

#include <fstream>
#include <string>
#include <system_error>

#include <unistd.h>

namespace tandem::driver {
namespace {

constexpr const char* kVendor = "2988";  // USB vendor of 3D Systems' Touch devices
constexpr const char* kMendSerial = "sudo usermod -aG dialout $USER, then log in again";
constexpr const char* kMendHid =
    "write KERNEL==\"hidraw*\", ATTRS{idVendor}==\"2988\", MODE=\"0666\" into "
    "/etc/udev/rules.d/80-touch.rules and plug it in again";

std::string FirstLineOf(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

/// Returns whether the file names the vendor of a HID device, "HID_ID=0003:00002988:00000302".
bool IsHidOfVendor(const std::filesystem::path& uevent) {
  std::ifstream in(uevent);
  for (std::string line; std::getline(in, line);) {
    if (line.rfind("HID_ID=", 0) == 0) {
      return line.find(std::string(":0000") + kVendor + ":") != std::string::npos;
    }
  }
  return false;
}

}  // namespace

UsbTouch FindUsbTouch(const std::filesystem::path& root) {
  UsbTouch touch;
  const auto look = [&](const char* kind, const char* prefix, const char* mend, auto is_it) {
    std::error_code failed;
    for (const auto& entry :
         std::filesystem::directory_iterator(root / "sys" / "class" / kind, failed)) {
      const std::string name = entry.path().filename().string();
      if (name.rfind(prefix, 0) != 0 || !is_it(entry.path())) continue;
      touch.is_plugged = true;
      const std::filesystem::path file = root / "dev" / name;
      if (!touch.refused.empty() || access(file.c_str(), R_OK | W_OK) == 0) continue;
      touch.refused = file.string();
      touch.mend = mend;
    }
  };
  look("tty", "ttyACM", kMendSerial, [](const std::filesystem::path& device) {
    return FirstLineOf(device / "device" / ".." / "idVendor") == kVendor;
  });
  look("hidraw", "hidraw", kMendHid, [](const std::filesystem::path& device) {
    return IsHidOfVendor(device / "device" / "uevent");
  });
  return touch;
}

}  // namespace tandem::driver
