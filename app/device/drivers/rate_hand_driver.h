#pragma once

#include <cstdint>
#include <string>

#include "app/device/drivers/rate_hand.h"
#include "app/device/tandem_device.h"

namespace tandem::driver {

/// The members that a DriverTable asks of a driver and that are alike for all inputs without
/// motors. Derived drivers move `hand_` in their Read().
class RateHandDriver {
 public:
  static std::string Capabilities(TandemDeviceCapabilities& can) {
    can.freedoms_in = 6;
    RateHand::Bear(can);
    return {};
  }
  std::int32_t Write(const TandemDeviceForce& force) noexcept {
    hand_.Feel(force);
    return TANDEM_OK;
  }
  static void Stop() noexcept {}  // no motors

 protected:
  explicit RateHandDriver(const TandemDeviceHost& host) : host_(&host) {}

  const TandemDeviceHost* host_;
  RateHand hand_;  // used by the loop alone
};

}  // namespace tandem::driver
