#include "engine/haptics/passive_device.h"

#include <utility>

namespace tandem {

PassiveDevice::PassiveDevice(HandScript script, const Pose& X_WB0)
    : script_(std::move(script)), X_WB0_(X_WB0) {
  if (script_.waypoints.empty()) script_.waypoints.emplace_back();
}

}  // namespace tandem
