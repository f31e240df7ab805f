#include "app/device/list_devices.h"

#include <algorithm>
#include <cstdio>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/device/open_driver.h"
#include "engine/base/text/clean_text.h"
#include "engine/base/text/json_text.h"
#include "engine/realtime/clock.h"

namespace tandem {
namespace {

constexpr std::int32_t kMostFound = 32;

}  // namespace

std::string DevicesOf(const std::string& name) {
  nlohmann::ordered_json out{{"name", name}};
  const Result<const TandemDriver*> loaded = DriverNamed(name);
  if (!loaded) {
    out["error"] = loaded.error().what;
    return JsonText(out, 2);
  }
  const TandemDriver& driver = **loaded;
  out["kind"] = driver.kind;
  out["options"] = driver.options;
  TandemDeviceHost host{};
  host.struct_size = sizeof host;
  host.abi_minor = TANDEM_DEVICE_ABI_MINOR;
  host.say = [](void*, const char* line) {
    std::fprintf(stderr, "device: %s\n", CleanText(line).c_str());
  };
  host.take = [](void*, TandemDeviceForce*) {};
  host.now_ns = [] {
    return MonotonicNowNs();
  };
  if (driver.init(&host) < 0) {
    out["error"] = "the driver does not start";
    return JsonText(out, 2);
  }
  std::vector<TandemDeviceFound> found(kMostFound);
  for (TandemDeviceFound& one : found) one.struct_size = sizeof one;
  const std::int32_t count = std::clamp(driver.list(found.data(), kMostFound), 0, kMostFound);
  nlohmann::ordered_json devices = nlohmann::ordered_json::array();
  for (std::int32_t i = 0; i < count; ++i) {
    const TandemDeviceFound& one = found[static_cast<std::size_t>(i)];
    devices.push_back({{"model", one.name},
                       {"options", one.options},
                       {"present", one.present != 0},
                       {"missing", one.missing},
                       {"mend", one.mend}});
  }
  out["devices"] = devices;
  driver.deinit();
  return JsonText(out, 2);
}

}  // namespace tandem
