#include "collab/lab/theory/exact_boundary.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace tandem {

namespace {

using Complex = std::complex<double>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Returns lambda of the common motion and of the differences.
std::array<double, 2> ModesOf(const LumpedCoupling& model) {
  return {1.0, -1.0 / static_cast<double>(std::max<std::size_t>(model.users, 2) - 1)};
}

/// Returns the larger squared frequency at which a root of the mode can cross the axis, then the
/// smaller; not positive where there is none. At u = w^2: |m s^2 + b s + kh + K + Bc s|^2 =
/// lambda^2 |K + Bc s|^2.
std::array<double, 2> CrossingSquares(const LumpedCoupling& model, double lambda) {
  const double k = model.stiffness + model.hand_stiffness;
  const double b = model.damping + model.relative_damping;
  const double square = model.mass * model.mass;
  const double lambda_bc = lambda * model.relative_damping;
  const double linear = b * b - 2.0 * model.mass * k - lambda_bc * lambda_bc;
  const double rest = (k - lambda * model.stiffness) * (k + lambda * model.stiffness);
  const double inner = linear * linear - 4.0 * square * rest;
  if (inner <= 0) return {0, 0};
  const double root = std::sqrt(inner);
  return {(-linear + root) / (2.0 * square), (-linear - root) / (2.0 * square)};
}

/// Returns the pairs of roots right of the axis that came there by crossing it.
int CrossedPairs(const LumpedCoupling& model, double lambda) {
  const std::array<double, 2> squares = CrossingSquares(model, lambda);
  int pairs = 0;
  for (std::size_t i = 0; i < squares.size(); ++i) {
    if (squares[i] <= 1e-12) continue;
    // a root crosses where lambda e^(-j w tau) = (Z + K + Bc s)/(K + Bc s), then once more each
    // turn
    const double w = std::sqrt(squares[i]);
    const Complex s(0, w);
    const Complex link = model.stiffness + model.relative_damping * s;
    const Complex body = model.mass * s * s + model.damping * s + model.hand_stiffness;
    double turn = std::fmod(-std::arg((body + link) / (lambda * link)), 2.0 * M_PI);
    if (turn < 1e-12) turn += 2.0 * M_PI;
    const double turned = w * model.delay_s - turn;
    if (turned < 0) continue;
    const int crossings = 1 + static_cast<int>(turned / (2.0 * M_PI));
    pairs += i == 0 ? crossings : -crossings;  // to the right at the larger frequency, back at the
                                               // smaller
  }
  return pairs;
}

/// Returns the w of w tan(w tau/2) = b/m. The left side grows from 0 to infinity over (0, pi/tau).
double CrossingFrequency(double delay_s, double damping, double mass) {
  double low = 0;
  double high = M_PI / delay_s;
  for (int i = 0; i < 200; ++i) {
    const double w = 0.5 * (low + high);
    (w * std::tan(0.5 * w * delay_s) < damping / mass ? low : high) = w;
  }
  return 0.5 * (low + high);
}

/// Returns the least x in (low, high] for which `holds` is false. It must be true at `low`. The
/// search takes steps of 1 %, then bisects. Infinite when it holds to `high`, and where a bound is
/// not a number.
template <class Holds>
double LeastFailing(double low, double high, const Holds& holds) {
  double good = low;
  double bad = low;
  while (true) {
    if (!(good < high)) return kInfinity;
    bad = std::min(1.01 * good, high);
    if (!holds(bad)) break;
    good = bad;
  }
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (good + bad);
    (holds(middle) ? good : bad) = middle;
  }
  return bad;
}

}  // namespace

bool IsStable(const LumpedCoupling& model) noexcept {
  for (const double lambda : ModesOf(model)) {
    // without delay; the link does nothing in the common motion then
    const double damping = model.damping + (1.0 - lambda) * model.relative_damping;
    if (damping < 0 || (damping == 0 && lambda < 0)) return false;
    if (CrossedPairs(model, lambda) > 0) return false;
  }
  return true;
}

Complex RightmostRoot(const LumpedCoupling& model) {
  const double m = model.mass;
  const double b = model.damping;
  const double kh = model.hand_stiffness;
  const double K = model.stiffness;
  const double Bc = model.relative_damping;
  const double tau = model.delay_s;
  const double fastest = 3.0 * std::sqrt((kh + 2.0 * K) / m) + 6.0 / tau;
  Complex rightmost(-kInfinity, 0);
  for (const double lambda : ModesOf(model)) {
    for (int i = 0; i < 15; ++i) {
      for (int j = 0; j < 400; ++j) {
        Complex s((-4.0 + 0.5 * i) / tau, fastest * j / 399.0);
        Complex step = s;
        for (int k = 0; k < 60 && std::abs(step) > 1e-13 * std::abs(s); ++k) {
          const Complex late = lambda * std::exp(-s * tau);
          const Complex value = m * s * s + b * s + kh + (K + Bc * s) * (1.0 - late);
          const Complex slope = 2.0 * m * s + b + Bc * (1.0 - late) + (K + Bc * s) * tau * late;
          step = value / slope;
          s -= step;
        }
        const Complex left =
            m * s * s + b * s + kh + (K + Bc * s) * (1.0 - lambda * std::exp(-s * tau));
        const bool is_root = std::abs(left) < 1e-6 * (kh + K) && std::abs(s) > 1e-7;
        if (is_root && s.real() > rightmost.real()) rightmost = {s.real(), std::abs(s.imag())};
      }
    }
  }
  return rightmost;
}

double CriticalStiffness(LumpedCoupling model, double most) {
  const double any = AnyDelayStiffness(model.damping, model.mass, model.relative_damping);
  return LeastFailing(std::max(any, 1e-3), most, [&model](double stiffness) {
    model.stiffness = stiffness;
    return IsStable(model);
  });
}

double CriticalStiffness(double delay_s, double damping, double mass) {
  const double mw = mass * CrossingFrequency(delay_s, damping, mass);
  return (damping * damping + mw * mw) / (2.0 * mass);
}

double OnsetFrequency(double delay_s, double damping, double mass) {
  return CrossingFrequency(delay_s, damping, mass);
}

double CriticalDelay(double stiffness, double damping, double mass) {
  const double square = 2.0 * mass * stiffness - damping * damping;
  if (square <= 0) return kInfinity;
  const double w = std::sqrt(square) / mass;
  return 2.0 / w * std::atan(damping / (mass * w));
}

double SafeStiffness(double delay_s, double damping, double mass) {
  return damping / delay_s + damping * damping / (3.0 * mass);
}

double PassiveStiffness(double delay_s, double damping) {
  return damping / delay_s;
}

double AnyDelayStiffness(double damping, double mass, double relative_damping) {
  return damping * (damping + 2.0 * relative_damping) / (2.0 * mass);
}

double PassiveInjection(double relative_damping_ratio) {
  // energy that the link gives at w tau = angle, to common motion and to differences: r (1 +- cos)
  // -+ sin / angle
  constexpr int kSteps = 200'000;
  constexpr double kLargest = 40.0;  // beyond it sin / angle is negligible
  double least = 0;
  for (int i = 1; i <= kSteps; ++i) {
    const double angle = kLargest * i / kSteps;
    const double across = std::sin(angle) / angle;
    const double alike = relative_damping_ratio * (1.0 - std::cos(angle)) + across;
    const double against = relative_damping_ratio * (1.0 + std::cos(angle)) - across;
    least = std::min({least, alike, against});
  }
  return -least;
}

double LargestLinearStiffness(double damping, double mass, double hand_stiffness,
                              double relative_damping) {
  LumpedCoupling model{.mass = mass,
                       .damping = damping,
                       .hand_stiffness = hand_stiffness,
                       .relative_damping = relative_damping};
  return LeastFailing(1.0, 1e5, [&model](double k0) {
    constexpr int kDelays = 300;
    for (int i = 1; i <= kDelays; ++i) {
      model.delay_s = static_cast<double>(i) / kDelays;
      model.stiffness = k0 * std::max(0.02, 1.0 - model.delay_s);
      if (!IsStable(model)) return false;
    }
    return true;
  });
}

}  // namespace tandem
