#pragma once

#include <filesystem>
#include <vector>

#include "engine/base/result.h"
#include "engine/base/spatial.h"

namespace tandem {

/// How a hand gives way: a mass, a damper and a spring to where it means to be. Rotation alike.
struct HandImpedance {
  double mass = 0.9;                // kg, of hand and device handle
  double damping = 5.0;             // N s/m, of the motion beside the intended one
  double stiffness = 300.0;         // N/m, to the intended place
  double inertia = 1e-3;            // kg m^2
  double rotation_damping = 0.02;   // N m s/rad
  double rotation_stiffness = 3.0;  // N m/rad
};

/// Where a hand means its body to be, and when: the body's centre of mass displaced by p_W from its
/// first place, the body turned by q_W (axes of W) from its first orientation. Intent, not a
/// collision-free path.
struct Waypoint {
  double t = 0;  // s, from the hand's start
  Vec3 p_W = Vec3::Zero();
  Quat q_W = Quat::Identity();
};

/// Somebody knocks against the hand, or leans on it: a wrench about the handle, from t on, for so
/// long.
struct Push {
  double t = 0;      // s, from the hand's start
  double lasts = 0;  // s
  Wrench F_D_W;
};

/// A scripted hand. File format (DESIGN of the hand file): docs/scene-format.md.
struct HandScript {
  HandImpedance impedance;
  Pose X_BD;  // grasp: the device's place in the body; B's axes are the file's
  std::vector<Waypoint> waypoints;  // t rising from 0; the first is the identity
  std::vector<Push> pushes;         // those at one time add up

  double duration() const { return waypoints.empty() ? 0.0 : waypoints.back().t; }

  /// The intended displacement at time t >= 0: minimum jerk in position, slerp with the same timing
  /// in rotation, between the waypoints either side; at rest at each; held after the last.
  Waypoint IntentAt(double t) const noexcept;
  /// Its rate of change: the velocity of the centre of mass and the angular velocity, in W.
  Twist IntendedTwistAt(double t) const noexcept;
  /// What the pushes of that time come to.
  Wrench PushAt(double t) const noexcept;
};

/// Reads a hand file. An error names the file, the place in it and what was expected there.
Result<HandScript> LoadHandScript(const std::filesystem::path& file);

}  // namespace tandem
