#pragma once

#include "engine/dynamics/rigid_body.h"

namespace tandem {

/// A pose on the way from a to b.
inline Pose Between(const Pose& a, const Pose& b, double share) {
  return {a.q.slerp(share, b.q), a.p + share * (b.p - a.p)};
}

/// Lets the copy of another's instance move only as far as there is energy for what that puts into
/// the spring (a passive set-position modulation: Lee & Huang, IEEE TRO 26 (2010) 354). With any
/// gains, delay and loss one end then gives at most its first credit. One gate for each end of a
/// link:
///
///   tank -= U of the copy's way, U = k/2 (|x - y'|^2 - |x - y|^2), with theta^T (I/m) theta for
///   rotation;   tank += 0.9 of what the drag took out;   what is above the credit overflows into a
///   counter that the other end is told of and adds to its own tank.
///
/// Made for the worst; under the laws that follow the delay it hardly ever acts. Used by the haptic
/// thread alone.
class EnergyGate {
 public:
  static constexpr double kCredit = 0.1;  // J
  static constexpr double kMost = 0.5;    // J that a tank holds of what the other gave

  /// How far a pose is from the body.
  struct Stretch {
    Vec3 turn = Vec3::Zero();  // rotation vector from the body to the pose
    double square = 0;         // m^2: |d|^2 + turn^T (I/m) turn
  };
  static Stretch StretchOf(const Pose& y_WB, const RigidState& own, const Mat3& per_mass) noexcept;

  /// Where the copy may be now that `y_WB` has come. `per_mass`: rotational inertia in W over the
  /// mass, m^2.
  Pose Admit(const Pose& y_WB, const RigidState& own, double stiffness,
             const Mat3& per_mass) noexcept;
  /// Energy (J) that left the tank otherwise: into a spring made stiffer while stretched.
  void Charge(double energy) noexcept { tank_ -= energy; }
  /// Energy (J) that drag took out of the body.
  void Earn(double dissipated) noexcept;
  /// The other end's counter, whenever it comes, J.
  void Receive(double its_overflow) noexcept;

  double tank() const noexcept { return tank_; }
  double overflow() const noexcept { return overflow_; }  // J, only grows
  /// How far the copy is from the body, as of the last Admit().
  const Stretch& stretch() const noexcept { return stretch_; }
  /// Whether the last Admit() held the copy back.
  bool clipped() const noexcept { return clipped_; }

 private:
  void Add(double energy) noexcept;

  double tank_ = kCredit;
  double overflow_ = 0;
  double received_ = 0;
  bool told_ = false;
  bool placed_ = false;
  bool clipped_ = false;
  Pose held_WB_;
  Stretch stretch_;  // of it
};

}  // namespace tandem
