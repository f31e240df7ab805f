#pragma once

#include <cstdint>
#include <string>

#include "collab/simulated/checkers/violations.h"
#include "engine/dynamics/rigid_body.h"

namespace tandem {

/// The state of a hand that hosts move, as seen from outside after a frame.
struct HandObservation {
  std::int64_t now_ns = 0;  // true time
  int held = -1;            // index of the moving body in hand
  int wanted = -1;          // index of the moving body asked for
  bool attached = false;    // the body is also grasped
  bool alone = false;       // no other peer holds it
  bool led = false;         // it comes back to another peer's instance, and the hand is let go of
  double mass = 0;          // kg, mass of that body
  RigidState body;          // state of that body
  Pose X_WG;                // grasp frame
  Pose requested;           // goal
  Pose handle;              // pose towards which the coupling pulls
  Wrench pull_B_W;          // wrench of the coupling on the body, at its centre
};

/// Judges the pull of a hand that hosts move (docs/decisions/0034-controller.md). Its goal leads
/// the part by no more than the spring may pull. The whole pull is bounded, and so is the speed
/// that the part gets from it:
///
///   |handle - G| <= F / 800 N/m,  0.5 rad      |pull| <= 2 F + 8 N s/m (goal's speed + that of G)
///   |v| <= goal's speed + F / sqrt(800 N/m m) + others' push, for a part in no other hand
///
/// F and the goal's speed are what hosts have last set. For 0.1 s after a change the larger value
/// counts.
class GoalHandChecker {
 public:
  GoalHandChecker(PeerId id, Violations& violations) : id_(id), violations_(&violations) {}

  /// Notes that a host's request to change a number was granted.
  void Set(const std::string& name, double value, std::int64_t now_ns);
  /// Judges a frame; call it after every frame.
  void Check(const HandObservation& sight);
  /// Returns the highest speed of the goal, m/s.
  double MostSpeed(std::int64_t now_ns) const { return speed_.At(now_ns); }

 private:
  struct Limit {
    double now = 0;
    double before = 0;
    std::int64_t changed_ns = 0;
    double At(std::int64_t now_ns) const;
  };

  PeerId id_;
  Violations* violations_;
  Limit force_{10, 10, 0};  // N
  Limit speed_{1, 1, 0};    // m/s
  int frames_ = 0;          // number of frames in which this part is grasped
  int held_ = -1;
};

}  // namespace tandem
