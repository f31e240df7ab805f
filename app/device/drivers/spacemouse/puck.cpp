#include "app/device/drivers/spacemouse/puck.h"

#include <algorithm>
#include <cmath>

namespace tandem::driver {

namespace {
constexpr double kClearly = 1.2;  // factor by which an axis must exceed the one that moves the hand
}

PuckRates RatesOf(const std::array<std::int32_t, 6>& axes, const PuckSettings& settings,
                  std::size_t& dominant) noexcept {
  std::array<double, 6> shares{};
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const double share = std::clamp(axes[i] / PuckSettings::kFullScale, -1.0, 1.0);
    // from zero at the edge of the dead zone, so that motion begins without a jump
    const double above = std::max(0.0, std::abs(share) - settings.dead_zone);
    shares[i] = std::copysign(above / (1 - settings.dead_zone), share);
  }
  if (settings.dominant) {
    for (std::size_t i = 0; i < shares.size(); ++i) {
      if (std::abs(shares[i]) > kClearly * std::abs(shares[dominant])) dominant = i;
    }
    for (std::size_t i = 0; i < shares.size(); ++i) {
      if (i != dominant) shares[i] = 0;
    }
  }
  // the daemon's z points away from the person, V's towards the person
  const double sign = settings.moves_camera ? -1 : 1;
  return {sign * settings.speed * Vec3(shares[0], shares[1], -shares[2]),
          sign * settings.turn * Vec3(shares[3], shares[4], -shares[5])};
}

}  // namespace tandem::driver
