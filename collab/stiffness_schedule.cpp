#include "collab/stiffness_schedule.h"

#include <algorithm>

namespace tandem {

std::optional<CouplingLaw> CouplingLawNamed(std::string_view name) {
  if (name == "p+d") return CouplingLaw::kPlusDamping;
  if (name == "linear") return CouplingLaw::kLinear;
  return std::nullopt;
}

double DesignDelay(double peak_loop_age_s) noexcept {
  return 0.5 * (1.1 * peak_loop_age_s + 0.005);
}

double LinkStiffness(CouplingLaw law, const CouplingLimits& limits, double peak_loop_age_s,
                     std::size_t users, double mass_max) noexcept {
  if (users < 2 || peak_loop_age_s > kLongestLoopAge) return 0;
  const double links = static_cast<double>(users - 1);
  if (law == CouplingLaw::kLinear) {
    const double tau = 0.5 * peak_loop_age_s;
    return limits.linear_stiffness * std::max(0.02, 1.0 - tau / 1.0) / links;
  }
  const double B = limits.damping_budget;
  const double te = DesignDelay(peak_loop_age_s);
  return limits.margin * std::min(limits.stiffness, B / te + B * B / (3.0 * mass_max)) / links;
}

double LinkDrag(CouplingLaw law, const CouplingLimits& limits, double stiffness_sum,
                double design_delay_s) noexcept {
  if (stiffness_sum <= 0) return 0;
  if (law == CouplingLaw::kLinear) return limits.damping_budget;
  return std::clamp(stiffness_sum * design_delay_s, 1.0, limits.damping_budget);
}

}  // namespace tandem
