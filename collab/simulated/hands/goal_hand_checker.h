#pragma once

#include <cstdint>
#include <string>

#include "collab/simulated/breakages.h"
#include "engine/dynamics/rigid_body.h"

namespace tandem {

/// What a hand that hosts move does, as seen from outside after a frame.
struct HandSight {
  std::int64_t now_ns = 0;  // true time
  int held = -1;            // in hand, among the moving bodies
  int wanted = -1;          // asked for
  bool attached = false;    // and grasped
  bool alone = false;       // no other holds it
  bool led = false;         // it comes back to another's instance, and the hand is let go of
  double mass = 0;          // kg, of that body
  RigidState body;          // it
  Pose X_WG;                // grasp frame
  Pose asked;               // goal
  Pose handle;              // where the coupling pulls to
  Wrench pull_B_W;          // of the coupling on the body, at its centre
};

/// How a hand may pull that hosts move (docs/decisions/0034-controller.md): its goal leads the part
/// by no more than the spring may pull, the whole pull is bounded, and so is the speed that the
/// part gets from it.
///
///   |handle - G| <= F / 800 N/m,  0.5 rad      |pull| <= 2 F + 8 N s/m (goal's speed + that of G)
///   |v| <= goal's speed + F / sqrt(800 N/m m) + what others push, of a part in no other hand
///
/// F and the goal's speed are what hosts have last set; for 0.1 s after a change the larger counts.
class GoalHandChecker {
 public:
  GoalHandChecker(PeerId id, Breakages& breakages) : id_(id), breakages_(&breakages) {}

  /// A host's request to change a number was answered: ok.
  void Set(const std::string& name, double value, std::int64_t now_ns);
  /// After every frame.
  void Look(const HandSight& sight);
  /// The fastest that the goal may go, m/s.
  double MostSpeed(std::int64_t now_ns) const { return speed_.At(now_ns); }

 private:
  struct Limit {
    double now = 0;
    double before = 0;
    std::int64_t changed_ns = 0;
    double At(std::int64_t now_ns) const;
  };

  PeerId id_;
  Breakages* breakages_;
  Limit force_{10, 10, 0};  // N
  Limit speed_{1, 1, 0};    // m/s
  int frames_ = 0;          // with this part grasped
  int held_ = -1;
};

}  // namespace tandem
