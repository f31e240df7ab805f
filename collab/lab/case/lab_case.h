#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "collab/coupling/coupling_law.h"
#include "collab/receive/link_conditioner.h"
#include "collab/trace/trace_store.h"
#include "engine/base/result.h"
#include "engine/dynamics/rigid_body.h"
#include "engine/haptics/hand_script.h"

namespace tandem {

/// A modelled hand and how it gives way (docs/stability.md §8: off, relaxed, heavy, firm; or own).
struct LabHand {
  std::string name;
  HandImpedance impedance;  // arm and device together; for rotation see HandNamed()
  // script of a hand file: it replaces the case's motion and has its own rotational impedance
  std::optional<HandScript> script{};
  // grasp, m from the body's centre of mass, axes of B; nothing: the scene's grasp
  std::optional<Vec3> grasp_B{};
};

/// Returns the hand of that name. "off" is the device alone, 0.2 kg and 0.3 N s/m. "relaxed",
/// "heavy" and "firm" add to it 0.7 kg and 5 N s/m, 1 kg and 2 N s/m, 1 kg with 10 N s/m and 800
/// N/m. Rotation is as in Turning(). Errors name the hands that there are.
Result<LabHand> HandNamed(const std::string& name, const Inertia& body);

/// Returns the hand with inertia, drag and spring of rotation that are those of travel times the
/// body's mean inertia over its mass. So the body turns as it travels.
HandImpedance Turning(HandImpedance hand, const Inertia& body);

/// The motion of the hands, from when all loops are closed, along x of W, where a scene has its
/// wall.
enum class LabMotion : std::uint8_t {
  kStill,
  kKick,    // the first hand is knocked: 5 N for 50 ms, one second in
  kMove,    // the first hand moves by 0.2 m from 2 s to 3 s, minimum jerk; the others give way
  kHold,    // the first hand moves as in kMove, by 0.1 m, and the others hold still where they are
  kSwing,   // the first hand goes to and fro by 0.1 m, a second each way, until 2/3 of the run
  kPress,   // all push along x with 2 N from 1.5 s to 4 s; the first is knocked at 2.5 s
  kPullOff  // all push so from 1.5 s to 5 s; the first is pulled away with 14 N for 150 ms at 3 s
};

struct LabLaw {
  std::string name = DefaultLaw()->name();
  CouplingLimits limits;
  double ratio = 1;           // factor on the law's stiffness; its drags are those for 1
  double boundary_ratio = 0;  // above 0: "constant" has that share of this case's k_crit as its
                              // stiffness
  bool gate = true;
  bool exchange_forces = false;  // the lab's unstable control: the other end's force is applied
};

/// The network between the users: one direction from the lesser to the greater number, one back.
struct LabNetwork {
  std::string name = "clean";
  LinkConditions there;
  LinkConditions back;
  double skew = 0;  // share of the case's delay that is taken from the way there and added back
  struct Step {
    double at_s = 0;  // time from when all loops are closed
    double delay_s = 0;
    bool cut = false;
  };
  std::vector<Step> schedule;  // at_s rising
  TraceChoice traced;          // traces, one for each way
};

/// One delay-injection experiment: complete peers that hold one shared body, each with a modelled
/// hand.
struct LabCase {
  std::string name;
  std::string scene = "free";  // free, wall, slot, ball, off_centre, or a scene file
  std::string body;            // name of the shared body in a scene file
  std::size_t users = 2;
  std::vector<LabHand> hands;  // hands of the users in order; the last one serves all further users
  LabMotion motion = LabMotion::kKick;
  LabLaw law;
  double delay_s = 0.1;  // one way
  LabNetwork network;    // its delays are added to delay_s
  double publish_hz = 1000;
  double seconds = 0;  // length from when all loops are closed; 0: DefaultDuration()
  std::uint64_t seed = 1;

  /// Returns whether the body touches nothing.
  bool IsFree() const { return scene == "free" || scene == "off_centre"; }
  /// Returns the mean of both ways: delay_s plus the delay of the network's traces.
  double MeanPathLength() const;
  /// Returns max(12 s, 40 mean ways).
  double DefaultDuration() const;
  /// Returns the case's length from when all loops are closed. RunCase() may go on longer while the
  /// motion decays.
  double Duration() const { return seconds > 0 ? seconds : DefaultDuration(); }
};

}  // namespace tandem
