#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.h"

namespace tandem {

/// Inputs of a law: the state of the couplings of one instance of a body.
struct LawInputs {
  double te_s = 0;             // delay that gains are made for: DesignDelay(peak_loop_age_s)
  double peak_loop_age_s = 0;  // worst loop age of the links in use
  std::size_t users = 2;       // this user and the peers on those links
  double mass_max = 1.5;       // kg; mass that may move together: body, device, arm
};

/// Gains of ONE of the users - 1 links. Rotational gains are the same times inertia over mass.
struct LinkLaw {
  double stiffness = 0;         // N/m
  double relative_damping = 0;  // N s/m; on the relative velocity of the instances
};

/// Decides how firmly two instances of a body may pull one another at a given delay (paper §6.1:
/// "the coupling stiffness is scaled by delay"). A law has no state. Each peer computes its own
/// pull from the states it holds:
///
///   F_i = sum_j k (y_j - x_i) + bc (u_j - v_i) - b v_i      y_j, u_j: x_j, v_j some time ago
///
/// Stability: let V = sum m v^2/2 + sum k |x_i - x_j|^2/2. As x_j - y_j is the integral of v_j over
/// the sample's age, the power that the delay adds is at most k (age_ij + age_ji) |v_i||v_j|
/// (Schwarz inequality). The drags dissipate it while 4 b_i b_j >= (k L)^2, L the loop age; for N
/// users while b_i >= sum_j k L/2 (Gershgorin). This holds for any jitter, loss, passive hand and
/// contact (Lee & Spong, IEEE TRO 22 (2006) 269; Nuno et al., IEEE TRO 25 (2009) 753). With te =
/// L/2 and a drag budget B it means k = B/te.
class CouplingLaw {
 public:
  CouplingLaw() = default;
  CouplingLaw(const CouplingLaw&) = delete;
  CouplingLaw& operator=(const CouplingLaw&) = delete;
  virtual ~CouplingLaw() = default;

  virtual const char* name() const noexcept = 0;
  virtual LinkLaw Link(const LawInputs& inputs) const noexcept = 0;
  /// Returns the drag against the ground, N s/m, for links whose stiffnesses sum to
  /// `stiffness_sum`.
  virtual double GroundDamping(const LawInputs& inputs, double stiffness_sum) const noexcept = 0;
};

struct CouplingLimits {
  double damping_budget = 10.0;      // B, N s/m that the hand may feel
  double stiffness = 500.0;          // K0, N/m; most stiffness without delay
  double margin = 0.8;               // sigma
  double linear_stiffness = 40.0;    // N/m; law "linear": k0; stable to 1 s with 10 N s/m of drag
  double constant_stiffness = 200;   // N/m; law "constant": stiffness
  double constant_damping = 0;       // N s/m; law "constant": drag against the ground
  double constant_link_damping = 0;  // N s/m; law "constant": damping between the instances
  double ratio = 1;                  // factor on the stiffness of any law; drags stay those for 1
};

/// s; a link with an older loop gets gains for its own age. The other links of the body get gains
/// for this age at most.
inline constexpr double kLongestCommonLoop = 2.4;

/// Returns half the worst loop age to be expected after a peak held for two seconds:
/// (1.1 L_peak + 5 ms) / 2. The peak alone falls short of the next second's worst in a quarter of
/// the cases, this in 2 to 6 %.
double DesignDelay(double peak_loop_age_s) noexcept;

LawInputs LawInputsAt(double peak_loop_age_s, std::size_t users, double mass_max) noexcept;

/// Returns the law of that name:
///
/// "p+d": k = sigma min(K0, B/te + B^2/(3 m_max)) / (N - 1), b = sum k te in [1, B].
///   The second term is what a bounded mass allows beyond B/te: the exact boundary of two free
///   instances is k_crit = (b^2 + m^2 w^2)/(2 m), w tan(w te/2) = b/m, and with atan t >= 3t/(3 +
/// "p+dd", the default: k = min(K0, 1.5 sigma (B/te + B^2/(3 m_max)), 4.2 B/te) / (N - 1),
///   bc = k te/2, b = 0.35 sum k te in [1, B]. It is half as firm again as "p+d", since part of the
///   drag is between the instances, where a common motion does not feel it. It is passive for a
///   constant delay with any hand, mass and grasp: .164 k te against the ground suffices, and b is
///   .35 k te, or B, which is at least .238 k te. m_max only shapes it. The energy gate pays for
///   what jitter adds through bc.
/// "linear", the paper's: k = k0 max(0.02, 1 - tau / 1 s) / (N - 1), b = B, with tau half the loop
///   age. Passive only while B >= k0/4 [1/s] (tau (1 - tau) <= 1/4); beyond 85 N/m unstable with
///   hands off.
/// "pdopt": k = sigma min(K0, 1.5 B/te) / (N - 1), bc = k te/2, b = sum k te/5, at least 1. The PD
///   link's passivity needs a ground damping of only g(r) k te, g = .164 at r = bc/(k te) = .5, for
///   a constant delay (after Lee & Spong); the energy gate pays for what jitter adds.
/// "constant": gains that ignore the delay, for the lab. An error unless `lab`, as is a ratio other
///   than 1.
Result<std::shared_ptr<const CouplingLaw>> MakeLaw(std::string_view name,
                                                   const CouplingLimits& limits = {},
                                                   bool lab = false);

/// Returns the names of all laws, the default first. `lab`: with those for the lab.
std::vector<std::string> LawNames(bool lab);

/// Returns "p+dd" with its default limits. This function alone decides which law is the default.
std::shared_ptr<const CouplingLaw> DefaultLaw();

}  // namespace tandem
