#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace tandem {

/// How stiff the coupling between two instances of a body may be at a given delay (paper §6.1: "the
/// coupling stiffness is scaled by delay").
///
/// Each peer computes its pull from the states it holds, F_i = sum_j k (y_j - x_i) - b v_i. The
/// delay can put at most k (age_ij + age_ji) |v_i| |v_j| into a link, so it is passive while 4 b_i
/// b_j >= k^2 L^2 (L the loop age, any jitter, any passive hand): k = b/te with te = L/2. A bounded
/// mass allows b^2/(3 m) more: from the exact boundary k_crit = (b^2 + m^2 w^2)/(2 m), w tan(w
/// te/2) = b/m, and atan t >= 3t/(3 + t^2).
enum class CouplingLaw {
  kPlusDamping,  // "p+d", the default: sigma min(K0, B/te + B^2/(3 m_max)) / (N - 1)
  kLinear  // "linear", the paper's shape: k0 max(0.02, 1 - tau / 1 s) / (N - 1); unstable for large
           // k0
};

std::optional<CouplingLaw> CouplingLawNamed(std::string_view name);

struct CouplingLimits {
  double damping_budget = 10.0;    // B, N s/m that the hand may feel
  double stiffness = 500.0;        // K0, N/m without delay
  double margin = 0.8;             // sigma
  double linear_stiffness = 40.0;  // k0 of the linear law, N/m: stable to 1 s with 10 N s/m of drag
};

inline constexpr double kLongestLoopAge = 2.4;  // s; beyond, the link is cut

/// The delay that gains are made for, half the worst loop age to be expected: te = (1.1 L_peak + 5
/// ms) / 2.
double DesignDelay(double peak_loop_age_s) noexcept;

/// Stiffness (N/m) of one of the `users` - 1 links of a body of largest moving mass `mass_max` (kg:
/// body, device, arm). 0 when the loop is older than kLongestLoopAge.
double LinkStiffness(CouplingLaw law, const CouplingLimits& limits, double peak_loop_age_s,
                     std::size_t users, double mass_max) noexcept;

/// Drag against the ground (N s/m) that the sum of the links' stiffness needs at that delay.
double LinkDrag(CouplingLaw law, const CouplingLimits& limits, double stiffness_sum,
                double design_delay_s) noexcept;

}  // namespace tandem
