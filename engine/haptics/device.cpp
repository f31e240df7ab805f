#include "engine/haptics/device.h"

#include <algorithm>
#include <cstdio>

namespace tandem {
namespace {

// scales all directions alike, so that the coupling's axes stay
Mat3 Held(const Mat3& gain, double most) {
  const double largest = gain.diagonal().maxCoeff();
  return largest > most ? Mat3((most / largest) * gain) : gain;
}

}  // namespace

CouplingGains LimitGains(const DeviceCapabilities& device, CouplingGains gains) noexcept {
  gains.stiffness = std::min(gains.stiffness, ValidGain(device.stiffness));
  gains.damping = std::min(gains.damping, ValidGain(device.damping));
  gains.rotation_stiffness = Held(gains.rotation_stiffness, ValidGain(device.rotation_stiffness));
  gains.rotation_damping = Held(gains.rotation_damping, ValidGain(device.rotation_damping));
  return gains;
}

std::string DescribeGainChange(const std::string& who, const DeviceCapabilities& can) {
  struct Gain {
    const char* name;
    const char* unit;
    double claimed;
  };
  std::string changes;
  for (const Gain& gain :
       {Gain{"a stiffness", "N/m", can.stiffness}, Gain{"a damping", "N s/m", can.damping},
        Gain{"a rotation stiffness", "N m/rad", can.rotation_stiffness},
        Gain{"a rotation damping", "N m s/rad", can.rotation_damping}}) {
    if (gain.claimed > 0) continue;
    char text[120];
    std::snprintf(text, sizeof text, "%s of %g %s is none: it counts as zero", gain.name,
                  gain.claimed, gain.unit);
    changes += (changes.empty() ? who + ": " : "; ") + text;
  }
  return changes;
}

}  // namespace tandem
