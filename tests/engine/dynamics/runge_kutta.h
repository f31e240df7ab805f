#pragma once

#include "engine/base/spatial.h"

namespace tandem::testing {

/// Integrates by Runge and Kutta's classical method of fourth order: y after `steps` steps of h
/// with dy/dt = rate(y). It is the reference that the implicit step approaches.
template <class Vector, class Rate>
Vector RungeKutta(Vector y, const Rate& rate, double h, int steps) {
  for (int i = 0; i < steps; ++i) {
    const Vector k1 = rate(y);
    const Vector k2 = rate(Vector(y + 0.5 * h * k1));
    const Vector k3 = rate(Vector(y + 0.5 * h * k2));
    const Vector k4 = rate(Vector(y + h * k3));
    y += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
  return y;
}

/// Returns dq/dt as coefficients x, y, z, w, of a rotation that turns at w_W.
inline Eigen::Vector4d QuatRate(const Quat& q, const Vec3& w_W) {
  return 0.5 * (Quat(0, w_W.x(), w_W.y(), w_W.z()) * q).coeffs();
}

}  // namespace tandem::testing
