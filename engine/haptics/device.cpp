#include "engine/haptics/device.h"

#include <algorithm>

namespace tandem {
namespace {

// in all directions alike, so that the coupling's axes stay
Mat3 Held(const Mat3& gain, double most) {
  const double largest = gain.diagonal().maxCoeff();
  return largest > most ? Mat3((most / largest) * gain) : gain;
}

}  // namespace

CouplingGains BorneBy(const DeviceCapabilities& device, CouplingGains gains) noexcept {
  gains.stiffness = std::min(gains.stiffness, device.stiffness);
  gains.damping = std::min(gains.damping, device.damping);
  gains.rotation_stiffness = Held(gains.rotation_stiffness, device.rotation_stiffness);
  gains.rotation_damping = Held(gains.rotation_damping, device.rotation_damping);
  return gains;
}

}  // namespace tandem
