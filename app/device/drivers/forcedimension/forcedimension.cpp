#include <algorithm>
#include <memory>
#include <string>

#include "app/device/drivers/driver_table.h"
#include "app/device/drivers/forcedimension/arm.h"
#include "app/device/drivers/forcedimension/dhd.h"

namespace tandem::driver {
namespace {

constexpr const char* kMendLibrary =
    "install the Force Dimension SDK and set FDSDK to its folder, or give library=FILE";
constexpr const char* kMendDevice =
    "plug it in and switch it on; for the right to use it, write SUBSYSTEM==\"usb\", "
    "ATTR{idVendor}==\"1451\", MODE=\"0666\" (a Falcon: \"0403\") into "
    "/etc/udev/rules.d/80-forcedimension.rules and plug it in again";

/// Returns how to mend a library that the loader refused with `why`.
const char* MendOf(const std::string& why) {
  return why.rfind("libusb-1.0.so.0:", 0) == 0 ? "apt install libusb-1.0-0" : kMendLibrary;
}

/// The driver `forcedimension`.
class ForceDimension {
 public:
  static constexpr const char* kName = "forcedimension";
  static constexpr const char* kKind =
      "haptic arm of Force Dimension (omega, sigma, delta, lambda) or Novint Falcon";
  static constexpr const char* kOptions =
      "device=INDEX,calibrate=yes|no,clutch=BUTTON,stop=BUTTON,library=FILE";

  static std::int32_t List(TandemDeviceFound* found, std::int32_t room) {
    if (room < 1) return 0;
    Dhd dhd{};
    if (const std::string fault = LoadDhd("", dhd); !fault.empty()) {
      Put(found->name, "");
      Put(found->missing, "Force Dimension's library libdrd (" + fault + ")");
      Put(found->mend, MendOf(fault));
      return 1;
    }
    const int count = std::max(0, dhd.GetDeviceCount());
    if (count == 0) {
      Put(found->missing, "no device is connected");
      Put(found->mend, kMendDevice);
      return 1;
    }
    const std::int32_t filled = std::min<std::int32_t>(room, count);
    for (std::int32_t i = 0; i < filled; ++i) {
      found[i].present = 1;
      Put(found[i].name, "Force Dimension " + std::to_string(i + 1));
      if (count > 1) Put(found[i].options, "device=" + std::to_string(i));
    }
    return filled;
  }

  static std::unique_ptr<ForceDimension> Open(const char* text, const TandemDeviceHost& host,
                                              std::string& fault) {
    Options options(text);
    Arm::Settings settings;
    settings.library = options.Text("library");
    settings.index = static_cast<int>(options.Number("device", 0, 0, 15));
    settings.calibrates = options.Flag("calibrate", false);
    settings.clutch = static_cast<int>(options.Number("clutch", 0, -1, 15));
    settings.stop = static_cast<int>(options.Number("stop", -1, -1, 15));
    fault = options.Fault();
    if (!fault.empty()) return nullptr;
    Dhd dhd{};
    fault = LoadDhd(settings.library, dhd);
    if (!fault.empty()) {
      fault += std::string(": ") + MendOf(fault);
      return nullptr;
    }
    std::unique_ptr<ForceDimension> device(new ForceDimension(dhd, host, settings));
    fault = device->arm_.Open();
    return fault.empty() ? std::move(device) : nullptr;
  }

  std::string Capabilities(TandemDeviceCapabilities& can) const {
    arm_.Capabilities(can);
    return {};
  }
  std::string Start() { return arm_.Start(); }
  std::string Trouble() const { return arm_.Trouble(); }
  std::int32_t Read(TandemDeviceState& state) noexcept { return arm_.Read(state); }
  std::int32_t Write(const TandemDeviceForce&) noexcept {
    arm_.Allow();
    return TANDEM_OK;
  }
  void Stop() noexcept { arm_.Stop(); }

 private:
  ForceDimension(const Dhd& dhd, const TandemDeviceHost& host, const Arm::Settings& settings)
      : arm_(dhd, host, settings) {}

  Arm arm_;
};

}  // namespace
}  // namespace tandem::driver

const TandemDriver tandem_driver =
    tandem::driver::DriverTable<tandem::driver::ForceDimension>::Table();
