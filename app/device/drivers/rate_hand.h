#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "app/device/tandem_device.h"
#include "engine/base/spatial.h"
#include "engine/base/units.h"

namespace tandem::driver {

/// The handle of an input without motors that reports rates or displacements: a puck, keys, a
/// mouse. The handle follows the user's motion and yields to force. Where contact holds the part,
/// the coupling pulls the handle back. The user's motion towards the contact then counts less, and
/// from kFullForce on not at all, so that the handle does not run ahead of the part. So the part
/// answers at once when the user turns back, and does not jump when it comes free. A larger force,
/// such as that of another user's hand, moves the handle slowly along.
///
/// A low-pass filters the force first. A coupling's damper answers a tick later to the speed
/// reported here. Without the filter, its answer could be larger than its cause.
class RateHand {
 public:
  static constexpr double kFreeForce = 1.0;       // N; a smaller force changes nothing
  static constexpr double kFullForce = 2.0;       // N; from here the hand does not move against the
                                                  // force
  static constexpr double kFreeMoment = 0.05;     // N m
  static constexpr double kFullMoment = 0.1;      // N m
  static constexpr double kYield = 0.03;          // m/s for each N above kFreeForce
  static constexpr double kYieldTurn = 0.6;       // rad/s for each N m above kFreeMoment
  static constexpr double kSmoothSeconds = 0.02;  // time constant of the force
  static constexpr double kWaySeconds = 0.01;     // time constant in which a displacement is used
                                                  // up
  static constexpr double kMostSpeed = 0.9;       // m/s; below the speed at which a device's force
                                                  // ends
  static constexpr double kMostTurn = 6.0;        // rad/s
  static constexpr double kLongestStep = 0.02;    // s; a longer step is cut to this

  /// Sets the greatest gains of a coupling at which the handle still comes to rest. The host lowers
  /// a coupling's gains to these: with --device-scale above 1 it acts stiffer on the handle.
  static void Bear(TandemDeviceCapabilities& can) noexcept {
    can.stiffness = 2000;
    can.damping = 20;
    can.rotation_stiffness = 15;
    can.rotation_damping = 0.3;
  }
  /// Adds a displacement that the user means, m and rad in V, beside its rates.
  void Add(const Vec3& way, const Vec3& turn) noexcept {
    way_left_ += way;
    turn_left_ += turn;
  }
  /// Advances to `now_ns` at the user's rates in V, m/s and rad/s. The first call only sets the
  /// time.
  void Move(const Vec3& v, const Vec3& w, std::int64_t now_ns) noexcept {
    const double dt =
        last_ns_ < 0 ? 0.0 : std::clamp(ToSeconds(now_ns - last_ns_), 0.0, kLongestStep);
    last_ns_ = now_ns;
    const double share = dt / (dt + kSmoothSeconds);
    smooth_force_ += share * (force_ - smooth_force_);
    smooth_moment_ += share * (moment_ - smooth_moment_);
    const Vec3 way_v = TakeWay(way_left_, dt, kMostSpeed);
    const Vec3 turn_w = TakeWay(turn_left_, dt, kMostTurn);
    velocity_ = ClampedLength(YieldedRate(v + way_v, smooth_force_, kFreeForce, kFullForce) +
                                  kYield * ExcessForce(smooth_force_, kFreeForce),
                              kMostSpeed);
    turn_ = ClampedLength(YieldedRate(w + turn_w, smooth_moment_, kFreeMoment, kFullMoment) +
                              kYieldTurn * ExcessForce(smooth_moment_, kFreeMoment),
                          kMostTurn);
    position_ += dt * velocity_;
    orientation_ = (RotationBy(dt * turn_) * orientation_).normalized();
  }
  /// Comes to rest when the input is gone, and forgets forces and pending displacements.
  void Rest() noexcept {
    velocity_ = turn_ = force_ = moment_ = smooth_force_ = smooth_moment_ = Vec3::Zero();
    way_left_ = turn_left_ = Vec3::Zero();
    last_ns_ = -1;
  }
  /// Takes the wrench on the hand, in V. Values that are not finite count as zero.
  void Feel(const TandemDeviceForce& force) noexcept {
    const Vec3 f(force.force);
    const Vec3 t(force.moment);
    force_ = f.allFinite() ? f : Vec3(Vec3::Zero());
    moment_ = t.allFinite() ? t : Vec3(Vec3::Zero());
  }
  void Tell(TandemDeviceState& state) const noexcept {
    state.valid = TANDEM_HAS_POSE | TANDEM_HAS_VELOCITY;
    for (int i = 0; i < 3; ++i) {
      state.position[i] = position_[i];
      state.velocity[i] = velocity_[i];
      state.angular_velocity[i] = turn_[i];
    }
    for (int i = 0; i < 4; ++i) state.orientation[i] = orientation_.coeffs()[i];
  }

 private:
  /// Takes the due share of a displacement, as a rate. A share that contact holds back is used up
  /// too, since the user moved the mouse and not the part.
  static Vec3 TakeWay(Vec3& left, double dt, double most) noexcept {
    if (dt <= 0) return Vec3::Zero();
    const Vec3 rate = ClampedLength(left / (dt + kWaySeconds), most);
    left -= dt * rate;
    return rate;
  }
  static Vec3 ExcessForce(const Vec3& force, double free) noexcept {
    const double size = force.norm();
    return size > free ? Vec3((1 - free / size) * force) : Vec3(Vec3::Zero());
  }
  /// Removes the part of a rate that goes against a force, the more the larger the force is.
  static Vec3 YieldedRate(const Vec3& rate, const Vec3& force, double free, double full) noexcept {
    const double size = force.norm();
    if (size <= free) return rate;
    const Vec3 against = -force / size;
    const double held = std::min(1.0, (size - free) / (full - free));
    return rate - held * std::max(0.0, rate.dot(against)) * against;
  }
  static Vec3 ClampedLength(const Vec3& rate, double most) noexcept {
    const double size = rate.norm();
    return size > most ? Vec3((most / size) * rate) : rate;
  }

  Vec3 position_ = Vec3::Zero();
  Quat orientation_ = Quat::Identity();
  Vec3 velocity_ = Vec3::Zero();
  Vec3 turn_ = Vec3::Zero();
  Vec3 force_ = Vec3::Zero();
  Vec3 moment_ = Vec3::Zero();
  Vec3 smooth_force_ = Vec3::Zero();
  Vec3 smooth_moment_ = Vec3::Zero();
  Vec3 way_left_ = Vec3::Zero();
  Vec3 turn_left_ = Vec3::Zero();
  std::int64_t last_ns_ = -1;
};

}  // namespace tandem::driver
