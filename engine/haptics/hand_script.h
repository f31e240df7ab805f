#pragma once

#include <filesystem>
#include <vector>

#include "engine/base/result.h"
#include "engine/base/spatial.h"

namespace tandem {

/// The impedance of a hand: a mass, a damper and a spring to the intended place. The same for
/// rotation.
struct HandImpedance {
  double mass = 0.9;                // mass of hand and device handle, kg
  double damping = 5.0;             // damping of the motion besides the intended one, N s/m
  double stiffness = 300.0;         // stiffness to the intended place, N/m
  double inertia = 1e-3;            // kg m^2
  double rotation_damping = 0.02;   // N m s/rad
  double rotation_stiffness = 3.0;  // N m/rad
};

/// The intended pose of a hand's body at a time. The body's centre of mass is displaced by p_W from
/// its first place. The body is turned by q_W (axes of W) from its first orientation. It is intent,
/// not a collision-free path.
struct Waypoint {
  double t = 0;  // s, from the hand's start
  Vec3 p_W = Vec3::Zero();
  Quat q_W = Quat::Identity();
};

/// A disturbance, as if a person knocks against the hand or leans on it: a wrench about the handle
/// from t on for the time `lasts`.
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
  std::vector<Push> pushes;         // pushes at the same time add up

  double duration() const { return waypoints.empty() ? 0.0 : waypoints.back().t; }

  /// Returns the intended displacement at time t >= 0. Between waypoints it is minimum jerk in
  /// position, and slerp with the same timing in rotation. It is at rest at each waypoint, and
  /// stays after the last.
  Waypoint IntentAt(double t) const noexcept;
  /// Returns its rate of change: the velocity of the centre of mass and the angular velocity, in W.
  Twist IntendedTwistAt(double t) const noexcept;
  /// Returns the sum of the pushes at that time.
  Wrench PushAt(double t) const noexcept;
};

/// Reads a hand file. An error names the file, the place in it and what was expected there.
Result<HandScript> LoadHandScript(const std::filesystem::path& file);

}  // namespace tandem
