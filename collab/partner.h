#pragma once

#include <cstdint>

#include "collab/delay_meter.h"
#include "collab/energy_gate.h"
#include "collab/messages.h"

namespace tandem {

/// Another user of a shared body, as one end of a link knows it.
struct Partner {
  PeerId peer = 0;       // 0: a free place
  bool present = false;  // false while its pull fades
  double fade_rate = 0;  // N/m/s of that fade
  bool heard = false;
  bool fresh_state = false;   // since the last frame
  std::int64_t heard_ns = 0;  // own time of the newest state
  ObjectState state;          // newest
  bool catching_up = false;   // its copy goes slowly to where it is after a silence
  bool linked = false;
  bool fresh_echo = false;  // newer than the one before; since the last frame
  std::uint32_t links_seq = 0;
  std::int64_t echo_ns = 0;       // newest own stamp that it holds
  std::int64_t last_echo_ns = 0;  // as of the last frame
  double its_stiffness = 0;       // N/m that it would use
  Wrench its_applied_B_W;         // on its instance, as it says
  Wrench computed_B_W;            // on ours, of our own end: told where forces are exchanged
  DelayMeter meter;               // of loop ages at which something came
  double offered_stiffness = 0;   // N/m that we would use
  double stiffness = 0;           // N/m in use
  bool falls = false;             // it did in the last frame,
  bool rises = false;             // or rose
  bool reached = false;           // the stiffness was what the delay allows, since it joined
  double relative_damping = 0;    // N s/m in use
  double moving = 0;              // share of its velocity in use: none of one not heard of
  double most_force = 1e30;       // N that its link may pull with
  double fade_share = 1;          // of fade_from that it may pull with; 1: it does not fade
  double fade_from = 0;           // N, as it began to fade
  Wrench applied_B_W;             // on our instance, in the last frame
  EnergyGate gate;
  Pose copy_WB;                    // what the gate has let through
  Twist V_copy_WB;                 // as last used: none of a copy that stands
  double way_force = 0;            // N by which the copy's way of this frame changed the link
  EnergyGate::Stretch stretch;     // from our instance to it, as of the last frame
  Vec3 turn_axis = Vec3::UnitX();  // from our instance to its

  bool closed() const noexcept { return present && heard && linked; }
  std::int64_t loop_age_ns(std::int64_t now_ns) const noexcept { return now_ns - echo_ns; }
};

/// Another user's instance of a shared body, where it was heard of last.
struct InstanceView {
  PeerId peer = 0;
  Pose X_WB;
};

/// What is shown and logged of a link.
struct LinkView {
  PeerId peer = 0;
  bool closed = false;      // it holds the body, and the loop to it is closed
  double loop_age_s = 0;    // now
  double te_s = 0;          // delay that the law is told of it
  double stiffness = 0;     // N/m in use
  double force = 0;         // N, on our instance
  double its_force = 0;     // N, on its instance, as it says
  double tank = 0;          // J, of our gate
  bool clipped = false;     // the gate holds the copy back
  double disagreement = 0;  // of the two wrenches of the link: |own + its| / the larger; 0 at rest
};

}  // namespace tandem
