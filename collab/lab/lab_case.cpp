#include "collab/lab/lab_case.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace tandem {

namespace {

struct Arm {
  std::string_view name;
  double mass;       // kg
  double damping;    // N s/m
  double stiffness;  // N/m
};

constexpr std::array<Arm, 4> kArms{
    {{"off", 0, 0, 0}, {"relaxed", 0.7, 5, 0}, {"heavy", 1, 2, 0}, {"firm", 1, 10, 800}}};
constexpr Arm kDevice{"device", 0.2, 0.3, 0};

}  // namespace

Result<LabHand> HandNamed(const std::string& name, const Inertia& body) {
  const auto arm = std::find_if(kArms.begin(), kArms.end(), [&](const Arm& each) {
    return each.name == name;
  });
  if (arm == kArms.end()) {
    return Error{"no hand of the lab is called '" + name +
                 "': there are off, relaxed, heavy and firm"};
  }
  const double turning = body.I_B.trace() / (3.0 * body.mass);  // m^2
  LabHand hand{name, {}};
  hand.impedance.mass = kDevice.mass + arm->mass;
  hand.impedance.damping = kDevice.damping + arm->damping;
  hand.impedance.stiffness = arm->stiffness;
  hand.impedance.inertia = turning * hand.impedance.mass;
  hand.impedance.rotation_damping = turning * hand.impedance.damping;
  hand.impedance.rotation_stiffness = turning * hand.impedance.stiffness;
  return hand;
}

double LabCase::LongEnough() const {
  return std::max(12.0, 40.0 * delay_s);
}

}  // namespace tandem
