#include "app/device/drivers/spacemouse/puck.h"

#include <algorithm>
#include <cmath>

namespace tandem::driver {

PuckRates RatesOf(const std::array<std::int32_t, 6>& axes, const PuckSettings& settings) noexcept {
  std::array<double, 6> shares{};
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const double share = std::clamp(axes[i] / PuckSettings::kFullScale, -1.5, 1.5);
    // from nothing at the dead zone's edge, so that motion begins without a jump
    const double above = std::max(0.0, std::abs(share) - settings.dead_zone);
    shares[i] = std::copysign(above / (1 - settings.dead_zone), share);
  }
  if (settings.dominant) {
    const auto strongest = std::ranges::max_element(shares, {}, [](double share) {
      return std::abs(share);
    });
    for (double& share : shares) {
      if (&share != &*strongest) share = 0;
    }
  }
  // z points away from the person there, and to the person in V
  const double sign = settings.moves_camera ? -1 : 1;
  return {sign * settings.speed * Vec3(shares[0], shares[1], -shares[2]),
          sign * settings.turn * Vec3(shares[3], shares[4], -shares[5])};
}

}  // namespace tandem::driver
