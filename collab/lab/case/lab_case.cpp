#include "collab/lab/case/lab_case.h"

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
  LabHand hand{name, {}};
  hand.impedance.mass = kDevice.mass + arm->mass;
  hand.impedance.damping = kDevice.damping + arm->damping;
  hand.impedance.stiffness = arm->stiffness;
  hand.impedance = Turning(hand.impedance, body);
  return hand;
}

HandImpedance Turning(HandImpedance hand, const Inertia& body) {
  const double per_mass = body.I_B.trace() / (3.0 * body.mass);  // m^2
  hand.inertia = per_mass * hand.mass;
  hand.rotation_damping = per_mass * hand.damping;
  hand.rotation_stiffness = per_mass * hand.stiffness;
  return hand;
}

double LabCase::MeanPathLength() const {
  const auto of_trace = [](const LinkTrace* trace) {
    return trace == nullptr ? 0.0 : 1e-3 * trace->facts().mean_delay_ms;
  };
  return delay_s + 0.5 * (of_trace(network.there.trace) + of_trace(network.back.trace));
}

double LabCase::DefaultDuration() const {
  return std::max(12.0, 40.0 * MeanPathLength());
}

}  // namespace tandem
