#include "app/device/drivers/scripted/scripted.h"

#include <memory>
#include <string>
#include <utility>

#include "app/device/drivers/exported_device.h"
#include "engine/haptics/passive_device.h"
#include "engine/haptics/scripted_device.h"

namespace tandem {
namespace {

/// Opens a scripted hand of the kind `Hand`; without a file it stands still.
template <typename Hand>
Result<std::unique_ptr<Device>> OpenScripted(const std::string& file, const Pose& X_WB0) {
  HandScript script;
  if (!file.empty()) {
    Result<HandScript> loaded = LoadHandScript(file);
    if (!loaded) return loaded.error();
    script = *std::move(loaded);
  }
  return std::unique_ptr<Device>(std::make_unique<Hand>(std::move(script), X_WB0));
}

struct ScriptedHand {
  static constexpr const char* kName = "scripted";
  static constexpr const char* kKind =
      "simulated hand that a script moves, and that feels force and yields";
  static constexpr const char* kOptions = "HAND-FILE";
  static Result<std::unique_ptr<Device>> Open(const std::string& file, const Pose& X_WB0) {
    return OpenScripted<ScriptedDevice>(file, X_WB0);
  }
};

struct PassiveHand {
  static constexpr const char* kName = "none";
  static constexpr const char* kKind = "simulated hand that a script moves, without force feedback";
  static constexpr const char* kOptions = "HAND-FILE";
  static Result<std::unique_ptr<Device>> Open(const std::string& file, const Pose& X_WB0) {
    return OpenScripted<PassiveDevice>(file, X_WB0);
  }
};

}  // namespace

const TandemDriver kScriptedDriver = driver::ExportedDevice<ScriptedHand>::Table();
const TandemDriver kPassiveDriver = driver::ExportedDevice<PassiveHand>::Table();

}  // namespace tandem
