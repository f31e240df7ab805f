#pragma once

#include <complex>
#include <cstddef>

namespace tandem {

/// N equal users who hold one body, along one axis. Each instance is one mass with all that moves
/// with it (body, device, arm). The copies are late by a constant delay. The equation of each
/// instance is
///
///   m x_i'' + b x_i' + kh x_i = sum_j k (x_j(t - tau) - x_i) + bc (v_j(t - tau) - v_i)
///
/// With K = (N-1) k and Bc = (N-1) bc, the modes lambda = 1 (common motion) and lambda = -1/(N-1)
/// (differences) obey
///
///   m s^2 + b s + kh + (K + Bc s) (1 - lambda e^(-s tau)) = 0.
///
/// Unequal delays of the two ways count as their mean. With two users the equation is (Z + K)^2 =
/// K^2 e^(-s (tau_12 + tau_21)), so only the loop matters.
struct LumpedCoupling {
  double mass = 1.5;            // m, kg
  double damping = 10;          // b against the ground, N s/m: body, device, hand and law
  double hand_stiffness = 0;    // kh, N/m
  double stiffness = 0;         // K, N/m, all links of an instance together
  double relative_damping = 0;  // Bc, N s/m, all links of an instance together
  double delay_s = 0.1;         // tau
  std::size_t users = 2;        // N
};

/// Returns whether every mode decays. The answer is exact: it counts for each mode the crossings of
/// the imaginary axis as tau grows from 0 (Walton & Marshall, IEE Proc. D 134 (1987) 101). A body
/// without a hand's spring may drift.
bool IsStable(const LumpedCoupling& model) noexcept;

/// Returns the rightmost root of all modes (1/s): growth in its real part, angular frequency in its
/// imaginary part. It leaves out the root at 0 of a body without a hand's spring. Newton's method
/// from a grid of starts takes some milliseconds.
std::complex<double> RightmostRoot(const LumpedCoupling& model);

/// Returns the least K (N/m) at which the coupling, all else as given, is not stable, to 1 in 10^9.
/// Infinite when there is none up to `most`.
double CriticalStiffness(LumpedCoupling model, double most = 1e5);

/// Returns the boundary for two users, no hand stiffness and no relative damping, in closed form:
///   k_crit = (b^2 + m^2 w^2) / (2 m),   w tan(w tau/2) = b/m,   0 < w < pi/tau.
double CriticalStiffness(double delay_s, double damping, double mass);
/// Returns the angular frequency w (rad/s) at which that boundary is crossed.
double OnsetFrequency(double delay_s, double damping, double mass);
/// Returns the least delay (s) that makes k unstable, the inverse of the above; infinite while k <=
/// b^2/(2 m).
double CriticalDelay(double stiffness, double damping, double mass);

/// Returns a stiffness below k_crit at every delay: b/tau + b^2/(3 m), as atan t >= 3t/(3 + t^2).
double SafeStiffness(double delay_s, double damping, double mass);
/// Returns the stiffness that is passive with any hand and mass: b/tau.
double PassiveStiffness(double delay_s, double damping);
/// Returns the stiffness that is stable at any delay without hands (small gain): b (b + 2 bc) / (2
/// m).
double AnyDelayStiffness(double damping, double mass, double relative_damping = 0);

/// Returns the drag against the ground, in parts of k tau, that makes a link passive at a constant
/// delay. The link has relative damping bc = r k tau. The drag is 1 without relative damping, .164
/// at r = .5 and .063 at r = 1.
double PassiveInjection(double relative_damping_ratio);

/// Returns the largest k0 (N/m) at which two users are stable at every delay up to 1 s under the
/// paper's law k = k0 max(0.02, 1 - tau / 1 s).
double LargestLinearStiffness(double damping, double mass, double hand_stiffness = 0,
                              double relative_damping = 0);

}  // namespace tandem
