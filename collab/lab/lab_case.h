#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "collab/coupling_law.h"
#include "collab/link_conditioner.h"
#include "collab/trace/trace_store.h"
#include "engine/base/result.h"
#include "engine/dynamics/rigid_body.h"
#include "engine/haptics/hand_script.h"

namespace tandem {

/// How a modelled hand gives way (docs/stability.md §8: off, relaxed, heavy, firm; or own).
struct LabHand {
  std::string name;
  HandImpedance impedance;  // of arm and device together; rotation's, see HandNamed()
  // a hand file's: it goes its own way in place of the case's motion, and turns as it says
  std::optional<HandScript> script{};
  // m, from the body's centre of mass, axes of B; nothing: where the scene has it
  std::optional<Vec3> grasp_B{};
};

/// "off": the device alone, 0.2 kg and 0.3 N s/m; "relaxed", "heavy", "firm" add to it 0.7 kg and
/// 5 N s/m, 1 kg and 2 N s/m, 1 kg with 10 N s/m and 800 N/m. Rotation has the same, times the
/// body's inertia over its mass, so that a turn of the body goes as its travel does. Errors name
/// the hands that there are.
Result<LabHand> HandNamed(const std::string& name, const Inertia& body);

/// A hand whose turning goes as its travel: inertia, drag and spring of rotation are those of
/// travel times the body's inertia over its mass.
HandImpedance Turning(HandImpedance hand, const Inertia& body);

/// What the hands do, from when all loops are closed; along x of W, where a scene has its wall.
enum class LabMotion : std::uint8_t {
  kStill,
  kKick,    // the first hand is knocked: 5 N for 50 ms, one second in
  kMove,    // the first hand moves by 0.2 m from 2 s to 3 s, minimum jerk; the others give way
  kHold,    // the same by 0.1 m, and the others hold still where they are
  kSwing,   // the first hand goes to and fro by 0.1 m, a second each way, until 2/3 of the run
  kPress,   // all lean on what is there with 2 N from 1.5 s to 4 s; the first is knocked at 2.5 s
  kPullOff  // all lean from 1.5 s to 5 s; the first is pulled away with 14 N for 150 ms at 3 s
};

struct LabLaw {
  std::string name = DefaultLaw()->name();
  CouplingLimits limits;
  double ratio = 1;           // of the law's stiffness; its drags are those for 1
  double boundary_ratio = 0;  // above 0: "constant", with that share of this case's k_crit
  bool gate = true;
  bool exchange_forces = false;  // the control that must be caught: the partner's force is applied
};

/// What lies between the users: one direction from the lesser to the greater number, one back.
struct LabNetwork {
  std::string name = "clean";
  LinkConditions there;
  LinkConditions back;
  double skew = 0;  // share of the case's delay that is taken from the way there and added back
  struct Step {
    double at_s = 0;  // from when all loops are closed
    double delay_s = 0;
    bool cut = false;
  };
  std::vector<Step> schedule;  // at_s rising
  TraceChoice traced;          // of which each way has its own
};

/// One delay-injection experiment: whole peers who hold one shared body, each with a modelled hand.
struct LabCase {
  std::string name;
  std::string scene = "free";  // free, wall, slot, ball, off_centre, or a scene file
  std::string body;            // of a scene file: its shared body
  std::size_t users = 2;
  std::vector<LabHand> hands;  // the last one is of all further users
  LabMotion motion = LabMotion::kKick;
  LabLaw law;
  double delay_s = 0.1;  // one way
  LabNetwork network;    // its delays are beside delay_s
  double publish_hz = 1000;
  double seconds = 0;  // from when all loops are closed; 0: LongEnough()
  std::uint64_t seed = 1;

  /// delay_s and what the network's traces have in the mean of both ways.
  double MeanWay() const;
  /// max(12 s, 40 mean ways).
  double LongEnough() const;
  /// What it lasts, from when all loops are closed; RunCase() may go on beyond that while it
  /// decays.
  double Lasts() const { return seconds > 0 ? seconds : LongEnough(); }
};

}  // namespace tandem
