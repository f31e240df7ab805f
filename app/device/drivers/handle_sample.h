#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "app/device/tandem_device.h"

namespace tandem::driver {

/// A handle as the driver's own thread last measured it, in V. Read() passes it on to the loop.
struct HandleSample {
  std::int64_t time_ns = 0;
  std::int32_t result = TANDEM_FAILED;
  std::uint32_t valid = 0;
  std::uint32_t buttons = 0;
  std::array<double, 3> p_VD{};
  std::array<double, 4> q_VD{};
  std::array<double, 3> v_VD{};
  std::array<double, 3> w_VD{};

  void CopyTo(TandemDeviceState& state) const noexcept {
    state.valid = valid;
    state.time_ns = time_ns;
    state.buttons = buttons;
    std::ranges::copy(p_VD, state.position);
    std::ranges::copy(q_VD, state.orientation);
    std::ranges::copy(v_VD, state.velocity);
    std::ranges::copy(w_VD, state.angular_velocity);
  }
};

}  // namespace tandem::driver
