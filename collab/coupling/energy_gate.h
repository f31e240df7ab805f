#pragma once

#include "engine/dynamics/rigid_body.h"

namespace tandem {

/// Returns a pose on the way from `a` to `b`; `share` is 0 at `a` and 1 at `b`.
inline Pose Interpolate(const Pose& a, const Pose& b, double share) {
  return {a.q.slerp(share, b.q), a.p + share * (b.p - a.p)};
}

/// Lets the copy of another peer's instance move only as far as a tank pays. The price is the
/// energy that the move puts into the spring (a passive set-position modulation: Lee & Huang, IEEE
/// TRO 26 (2010) 354). With any gains, delay and loss one end then gives at most its first credit.
/// There is one gate at each end of a link:
///
///   tank -= U of the copy's move, U = k/2 (|x - y'|^2 - |x - y|^2), with theta^T (I/m) theta for
///   rotation;   tank += 0.9 of the energy that drag dissipated;   energy above the credit goes to
///   an overflow counter, which the other end receives and adds to its own tank.
///
/// The gate is made for the worst case; it rarely acts under a law that follows the delay. Used by
/// the haptic thread alone.
class EnergyGate {
 public:
  static constexpr double kCredit = 0.1;  // J
  static constexpr double kMost = 0.5;    // J; most that a tank holds with the other end's overflow

  /// The distance of a pose from the body.
  struct Stretch {
    Vec3 turn = Vec3::Zero();  // rotation vector from the body to the pose
    double square = 0;         // m^2: |d|^2 + turn^T (I/m) turn
  };
  static Stretch StretchOf(const Pose& y_WB, const RigidState& own, const Mat3& per_mass) noexcept;

  /// Returns where the copy may be, given that `y_WB` was received. `per_mass`: rotational inertia
  /// in W over the mass, m^2.
  Pose Modulate(const Pose& y_WB, const RigidState& own, double stiffness,
                const Mat3& per_mass) noexcept;
  /// Takes energy (J) that left the tank another way: into a spring that grew stiffer while
  /// stretched.
  void Debit(double energy) noexcept { tank_ -= energy; }
  /// Adds energy (J) that drag took out of the body.
  void Credit(double dissipated) noexcept;
  /// Takes the other end's overflow counter, J, whenever it arrives.
  void Receive(double its_overflow) noexcept;

  double tank() const noexcept { return tank_; }
  double overflow() const noexcept { return overflow_; }  // J; never falls
  /// The distance of the copy from the body at the last Modulate().
  const Stretch& stretch() const noexcept { return stretch_; }
  /// Returns whether the last Modulate() held the copy back.
  bool clipped() const noexcept { return clipped_; }

 private:
  void Add(double energy) noexcept;

  double tank_ = kCredit;
  double overflow_ = 0;
  double received_ = 0;
  bool reported_ = false;
  bool placed_ = false;
  bool clipped_ = false;
  Pose held_WB_;
  Stretch stretch_;  // from the body to held_WB_
};

}  // namespace tandem
