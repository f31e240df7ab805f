#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "app/device/tandem_device.h"
#include "engine/base/spatial.h"

namespace tandem::driver {

/// The handle of an input that tells rates and has no motors: a puck, keys. The handle moves at the
/// user's rate, and gives way to force: where contact holds a part up, the coupling pulls the
/// handle back, and the handle does not run ahead of the part. So the part answers at once when the
/// user turns back, and is not flung when it comes free.
///
/// Beyond a threshold the handle moves along the force at a speed in proportion to what is above
/// it. A coupling of k N/m turns that into a decay of kYield * k a second, which is stable at 1000
/// Hz with a tick of delay up to 3000 N/m.
class RateHand {
 public:
  static constexpr double kFreeForce = 1.5;     // N that move the handle not
  static constexpr double kFreeMoment = 0.05;   // N m
  static constexpr double kYield = 0.3;         // m/s for each N above
  static constexpr double kYieldTurn = 15.0;    // rad/s for each N m above
  static constexpr double kMostSpeed = 0.9;     // m/s, below what ends a device's force
  static constexpr double kMostTurn = 6.0;      // rad/s
  static constexpr double kLongestStep = 0.02;  // s; what a longer one would add is left out

  /// Moves on to `now_ns` at the user's rates in V, m/s and rad/s. The first call only sets the
  /// time.
  void Move(const Vec3& v, const Vec3& w, std::int64_t now_ns) noexcept {
    const double dt =
        last_ns_ < 0 ? 0.0
                     : std::clamp(1e-9 * static_cast<double>(now_ns - last_ns_), 0.0, kLongestStep);
    last_ns_ = now_ns;
    velocity_ = Within(v + kYield * Above(force_, kFreeForce), kMostSpeed);
    turn_ = Within(w + kYieldTurn * Above(moment_, kFreeMoment), kMostTurn);
    position_ += dt * velocity_;
    orientation_ = (RotationBy(dt * turn_) * orientation_).normalized();
  }
  /// Stands still: the input is gone, and so is what it had felt.
  void Rest() noexcept {
    velocity_ = turn_ = force_ = moment_ = Vec3::Zero();
    last_ns_ = -1;
  }
  /// What acts on the hand, in V. What is no number counts as nothing.
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
  static Vec3 Above(const Vec3& force, double free) noexcept {
    const double size = force.norm();
    return size > free ? Vec3((1 - free / size) * force) : Vec3(Vec3::Zero());
  }
  static Vec3 Within(const Vec3& rate, double most) noexcept {
    const double size = rate.norm();
    return size > most ? Vec3((most / size) * rate) : rate;
  }

  Vec3 position_ = Vec3::Zero();
  Quat orientation_ = Quat::Identity();
  Vec3 velocity_ = Vec3::Zero();
  Vec3 turn_ = Vec3::Zero();
  Vec3 force_ = Vec3::Zero();
  Vec3 moment_ = Vec3::Zero();
  std::int64_t last_ns_ = -1;
};

}  // namespace tandem::driver
