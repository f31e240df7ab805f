#include "app/device/drivers.h"

#include "app/device/fake_driver.h"
#include "engine/haptics/passive_device.h"
#include "engine/haptics/scripted_device.h"

namespace tandem {
namespace {

/// A scripted hand of the kind `Hand`; without a file it stands still.
template <typename Hand>
Result<std::unique_ptr<Device>> Scripted(const std::string& file, const Pose& X_WB0) {
  HandScript script;
  if (!file.empty()) {
    Result<HandScript> loaded = LoadHandScript(file);
    if (!loaded) return loaded.error();
    script = *std::move(loaded);
  }
  return std::unique_ptr<Device>(std::make_unique<Hand>(std::move(script), X_WB0));
}

}  // namespace

const std::vector<DriverName>& Drivers() {
  static const std::vector<DriverName> drivers{
      {"scripted:FILE", "a hand that a script moves, and that feels and gives way"},
      {"none:FILE", "a hand that a script moves, without force feedback"},
      {"fake:OPTIONS", "for tests: keeps what its motor gets, and misbehaves on request"}};
  return drivers;
}

Result<std::unique_ptr<Device>> OpenDriver(const std::string& asked, const Pose& X_WB0) {
  const std::size_t colon = asked.find(':');
  const std::string name = asked.substr(0, colon);
  const std::string options = colon == std::string::npos ? "" : asked.substr(colon + 1);
  if (name == "scripted") return Scripted<ScriptedDevice>(options, X_WB0);
  if (name == "none") return Scripted<PassiveDevice>(options, X_WB0);
  if (name == "fake") return FakeDriver::Make(options, X_WB0);
  std::string known;
  for (const DriverName& driver : Drivers()) known += std::string(" ") + driver.name;
  return Error{"no driver is called '" + name + "'; there are" + known};
}

}  // namespace tandem
