#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "app/device/drivers/driver_table.h"
#include "app/device/drivers/openhaptics/hd.h"
#include "app/device/drivers/openhaptics/stylus.h"
#include "app/device/drivers/openhaptics/usb_touch.h"

namespace tandem::driver {
namespace {

constexpr const char* kMendLibrary =
    "install 3D Systems' OpenHaptics runtime and the device's driver, or give library=FILE";

/// Returns how to mend a library that the loader refused with `why`.
std::string MendOf(const std::string& why) {
  // the vendor's programs need the old version, which Debian has beside the new one
  if (why.rfind("libncurses.so.5:", 0) == 0) return "apt install libncurses5";
  const std::string library = why.substr(0, why.find(':'));
  if (library.find(".so") == std::string::npos || library.find("libHD") != std::string::npos) {
    return kMendLibrary;
  }
  return "install 3D Systems' device driver again: " + library + " belongs to it";
}

/// Returns whether the vendor's setup has stored the settings of a device.
bool IsSetUp() {
  std::vector<std::filesystem::path> folders;
  // NOLINTBEGIN(concurrency-mt-unsafe): nothing of ours sets the environment
  if (const char* home = std::getenv("GTDD_HOME")) {
    folders.emplace_back(std::filesystem::path(home) / "config");
  } else {
    const char* own = std::getenv("HOME");
    if (own != nullptr) folders.emplace_back(std::filesystem::path(own) / ".3dsystems/config");
    folders.emplace_back("/usr/share/3DSystems/config");
  }
  // NOLINTEND(concurrency-mt-unsafe)
  for (const std::filesystem::path& folder : folders) {
    std::error_code failed;
    if (std::filesystem::is_directory(folder, failed) &&
        !std::filesystem::is_empty(folder, failed) && !failed) {
      return true;
    }
  }
  return false;
}

/// The driver `openhaptics`.
class OpenHaptics {
 public:
  static constexpr const char* kName = "openhaptics";
  static constexpr const char* kKind = "haptic stylus of 3D Systems (Touch, Phantom), by libHD";
  static constexpr const char* kOptions =
      "device=NAME,calibrate=yes|no,clutch=BUTTON,stop=BUTTON,library=FILE";

  static std::int32_t List(TandemDeviceFound* found, std::int32_t room) {
    if (room < 1) return 0;
    Hd hd{};
    if (const std::string fault = LoadHd(LibraryOfTheEnvironment(), hd); !fault.empty()) {
      Put(found->missing, "3D Systems' library libHD (" + fault + ")");
      Put(found->mend, MendOf(fault));
    } else if (!IsSetUp()) {
      Put(found->missing, "no device is set up");
      Put(found->mend, "plug it in, switch it on, and set it up by the vendor's Touch_Setup");
    } else {
      // only opening the device shows whether it is switched on
      const UsbTouch usb = FindUsbTouch();
      Put(found->name, usb.is_plugged ? "Touch" : "Touch or Phantom");
      found->present = usb.refused.empty() ? 1 : 0;
      if (!usb.refused.empty()) Put(found->missing, "the right to use " + usb.refused);
      Put(found->mend, usb.mend);
    }
    return 1;
  }

  static std::unique_ptr<OpenHaptics> Open(const char* text, const TandemDeviceHost& host,
                                           std::string& fault) {
    Options options(text);
    Stylus::Settings settings;
    settings.device = options.Text("device");
    settings.calibrates = options.Flag("calibrate", false);
    settings.clutch = static_cast<int>(options.Number("clutch", 0, -1, 3));
    settings.stop = static_cast<int>(options.Number("stop", -1, -1, 3));
    const std::string library = options.Text("library", LibraryOfTheEnvironment());
    fault = options.Fault();
    if (!fault.empty()) return nullptr;
    Hd hd{};
    fault = LoadHd(library, hd);
    if (!fault.empty()) {
      fault += ": " + MendOf(fault);
      return nullptr;
    }
    std::unique_ptr<OpenHaptics> device(new OpenHaptics(hd, host, settings));
    fault = device->stylus_.Open();
    return fault.empty() ? std::move(device) : nullptr;
  }

  std::string Capabilities(TandemDeviceCapabilities& can) const {
    stylus_.Capabilities(can);
    return {};
  }
  std::string Start() { return stylus_.Start(); }
  std::string Trouble() const { return stylus_.Trouble(); }
  std::int32_t Read(TandemDeviceState& state) noexcept { return stylus_.Read(state); }
  std::int32_t Write(const TandemDeviceForce&) noexcept {
    stylus_.Allow();
    return TANDEM_OK;
  }
  void Stop() noexcept { stylus_.Stop(); }

 private:
  OpenHaptics(const Hd& hd, const TandemDeviceHost& host, const Stylus::Settings& settings)
      : stylus_(hd, host, settings) {}

  static std::string LibraryOfTheEnvironment() {
    const char* file = std::getenv("TANDEM_LIBHD");  // NOLINT(concurrency-mt-unsafe)
    return file != nullptr ? file : "";
  }

  Stylus stylus_;
};

}  // namespace
}  // namespace tandem::driver

const TandemDriver tandem_driver =
    tandem::driver::DriverTable<tandem::driver::OpenHaptics>::Table();
