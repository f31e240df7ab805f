#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace tandem {

using Vec3 = Eigen::Vector3d;
using Vec3f = Eigen::Vector3f;
using Mat3 = Eigen::Matrix3d;
using Quat = Eigen::Quaterniond;
using Vec6 = Eigen::Matrix<double, 6, 1>;  // moments or angular parts first, as in Wrench and Twist
using Mat6 = Eigen::Matrix<double, 6, 6>;

/// The pose of a frame in another: X_WB takes coordinates in B to coordinates in W.
struct Pose {
  Quat q = Quat::Identity();
  Vec3 p = Vec3::Zero();  // m

  Vec3 operator*(const Vec3& p_BQ) const { return q * p_BQ + p; }
  Pose operator*(const Pose& X_BC) const { return {q * X_BC.q, q * X_BC.p + p}; }
  Pose Inverse() const { return {q.conjugate(), -(q.conjugate() * p)}; }
};

/// V_WB: the motion of frame B in W, expressed in W.
struct Twist {
  Vec3 w = Vec3::Zero();  // rad/s
  Vec3 v = Vec3::Zero();  // velocity of B's origin, m/s
};

/// F_B_W: a force on B and its moment about B's origin, expressed in W.
struct Wrench {
  Vec3 tau = Vec3::Zero();  // N m
  Vec3 f = Vec3::Zero();    // N

  Wrench& operator+=(const Wrench& other) {
    tau += other.tau;
    f += other.f;
    return *this;
  }
};

/// Returns the matrix [a]x for which [a]x b = a x b.
inline Mat3 CrossMatrix(const Vec3& a) {
  Mat3 m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

/// Returns the rotation vector (axis times angle, angle in [0, pi]) of q.
inline Vec3 RotationVector(const Quat& q) {
  const double sign = q.w() < 0 ? -1.0 : 1.0;
  const Vec3 v = sign * q.vec();
  const double sine = v.norm();  // sine of half the angle
  if (sine < 1e-9) return 2.0 * v;
  return (2.0 * std::atan2(sine, sign * q.w()) / sine) * v;
}

/// Returns the farthest that any surface point goes in a motion (paper §5): |t| + 2 sin(angle/2) r.
/// r is the largest distance of any point from the frame's origin. All in m and rad.
inline double TravelOf(const Vec3& translation, double angle, double radius) {
  return translation.norm() + 2.0 * std::sin(0.5 * angle) * radius;
}

/// Returns the rotation by `angle_axis` (axis times angle).
inline Quat RotationBy(const Vec3& angle_axis) {
  const double angle = angle_axis.norm();
  const double half = 0.5 * angle;
  const double scale = angle < 1e-9 ? 0.5 : std::sin(half) / angle;
  Quat q;
  q.w() = std::cos(half);
  q.vec() = scale * angle_axis;
  return q.normalized();
}

/// An axis-aligned box; empty until a point is added.
struct Bounds {
  Vec3 min = Vec3::Constant(1e300);
  Vec3 max = Vec3::Constant(-1e300);

  void Add(const Vec3& p) {
    min = min.cwiseMin(p);
    max = max.cwiseMax(p);
  }
  bool empty() const { return min.x() > max.x(); }
  Vec3 size() const { return empty() ? Vec3(Vec3::Zero()) : Vec3(max - min); }
  Vec3 centre() const { return 0.5 * (min + max); }
  bool Overlaps(const Bounds& other) const {
    return (min.array() <= other.max.array()).all() && (other.min.array() <= max.array()).all();
  }
};

}  // namespace tandem
