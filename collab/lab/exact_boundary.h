#pragma once

#include <complex>
#include <cstddef>

namespace tandem {

/// N users alike who hold one body, each instance one mass with what moves with it (body, device,
/// arm), along one axis; the copies are constantly late. All as one instance has it:
///
///   m x_i'' + b x_i' + kh x_i = sum_j k (x_j(t - tau) - x_i) + bc (v_j(t - tau) - v_i)
///
/// Its modes, lambda = 1 (all alike) and lambda = -1/(N-1) (differences), with K = (N-1) k and Bc =
/// (N-1) bc:   m s^2 + b s + kh + (K + Bc s) (1 - lambda e^(-s tau)) = 0.
///
/// Lag that both ways do not share alike counts as its mean: with two users the equation is (Z +
/// K)^2 = K^2 e^(-s (tau_12 + tau_21)), so only the loop matters.
struct LumpedCoupling {
  double mass = 1.5;            // m, kg
  double damping = 10;          // b against the ground, N s/m: body, device, hand and law
  double hand_stiffness = 0;    // kh, N/m
  double stiffness = 0;         // K, N/m, of all links of an instance
  double relative_damping = 0;  // Bc, N s/m, of all links of an instance
  double delay_s = 0.1;         // tau
  std::size_t users = 2;        // N
};

/// Whether every mode dies out: exact, by counting for each mode the crossings of the imaginary
/// axis as tau grows from nothing (Walton & Marshall, IEE Proc. D 134 (1987) 101). A body that
/// nothing holds may drift.
bool IsStable(const LumpedCoupling& model) noexcept;

/// The rightmost root of all modes (1/s): growth in its real part, angular frequency in its
/// imaginary part. The root at nothing of a body that nothing holds is left out. By Newton's method
/// from a grid of starts: some milliseconds.
std::complex<double> RightmostRoot(const LumpedCoupling& model);

/// The least K (N/m) at which the coupling, all else as given, is not stable: to 1 in 10^9.
/// Infinite when there is none up to `most`.
double CriticalStiffness(LumpedCoupling model, double most = 1e5);

/// The same for two users, no hand stiffness and no relative damping, in closed form:
///   k_crit = (b^2 + m^2 w^2) / (2 m),   w tan(w tau/2) = b/m,   0 < w < pi/tau.
double CriticalStiffness(double delay_s, double damping, double mass);
/// The angular frequency w (rad/s) at which that boundary is crossed.
double OnsetFrequency(double delay_s, double damping, double mass);
/// The inverse: the least delay (s) that makes k unstable; infinite while k <= b^2/(2 m).
double CriticalDelay(double stiffness, double damping, double mass);

/// Below k_crit at every delay: b/tau + b^2/(3 m), as atan t >= 3t/(3 + t^2).
double SafeStiffness(double delay_s, double damping, double mass);
/// Passive, whatever hand and mass: b/tau.
double PassiveStiffness(double delay_s, double damping);
/// Stable at any delay, hands off (small gain): b (b + 2 bc) / (2 m).
double AnyDelayStiffness(double damping, double mass, double relative_damping = 0);

/// Drag against the ground, in parts of k tau, that makes a link with relative damping bc = r k tau
/// passive at a constant delay: 1 without, .164 at r = .5, .063 at r = 1.
double PassiveInjection(double relative_damping_ratio);

/// The largest k0 (N/m) for which the paper's law k = k0 max(0.02, 1 - tau / 1 s) is stable, N = 2,
/// at every delay to 1 s.
double LargestLinearStiffness(double damping, double mass, double hand_stiffness = 0,
                              double relative_damping = 0);

}  // namespace tandem
