#pragma once

#include <cstdint>

#include "collab/coupling/delay_meter.h"
#include "collab/coupling/energy_gate.h"
#include "collab/session/messages.h"

namespace tandem {

/// Another user of a shared body, as this end of the link knows it.
struct Partner {
  PeerId peer = 0;       // 0: a free place
  bool present = false;  // false while its pull fades
  double fade_rate = 0;  // N/m/s; rate of that fade
  bool heard = false;
  bool fresh_state = false;   // a state came since the last frame
  std::int64_t heard_ns = 0;  // own clock; arrival of the newest state
  ObjectState state;          // newest
  bool catching_up = false;   // after a silence its copy moves slowly to the new pose
  bool linked = false;
  bool fresh_echo = false;  // a newer echo came since the last frame
  std::uint32_t links_seq = 0;
  std::int64_t echo_ns = 0;       // newest own stamp that it has
  std::int64_t last_echo_ns = 0;  // echo_ns in the last frame
  double its_stiffness = 0;       // N/m; its offer
  Wrench its_applied_B_W;         // wrench on its instance, as it says
  Wrench computed_B_W;  // wrench of our end on our instance: sent where forces are exchanged
  DelayMeter meter;     // meter of the loop ages at arrivals
  double offered_stiffness = 0;  // N/m; our offer
  double stiffness = 0;          // N/m in use
  bool falls = false;            // the stiffness fell in the last frame,
  bool rises = false;            // or rose
  bool reached = false;          // the stiffness has reached what the delay allows, since it joined
  double relative_damping = 0;   // N s/m in use
  double moving = 0;             // share of its velocity in use: 0 for a silent partner
  double most_force = 1e30;      // N; most force of its link
  double fade_share = 1;         // share of fade_from allowed as its force; 1: it does not fade
  double fade_from = 0;          // N; force when the fade began
  Wrench applied_B_W;            // wrench on our instance in the last frame
  EnergyGate gate;
  Pose copy_WB;                    // pose that the gate has let through
  Twist V_copy_WB;                 // twist as last used: 0 for a copy that stands
  double way_force = 0;            // N; change of the link's force by the copy's move in this frame
  EnergyGate::Stretch stretch;     // from our instance to the copy, in the last frame
  Vec3 turn_axis = Vec3::UnitX();  // axis of the turn from our instance to its copy

  bool closed() const noexcept { return present && heard && linked; }
  std::int64_t loop_age_ns(std::int64_t now_ns) const noexcept { return now_ns - echo_ns; }
  double loop_age_s(std::int64_t now_ns) const noexcept {
    return 1e-9 * static_cast<double>(loop_age_ns(now_ns));
  }
};

/// Another user's instance of a shared body, where last heard.
struct InstanceView {
  PeerId peer = 0;
  Pose X_WB;
};

/// Figures of a link, shown and logged.
struct LinkView {
  PeerId peer = 0;
  bool closed = false;      // the peer holds the body, and the loop to it is closed
  double loop_age_s = 0;    // present loop age
  double te_s = 0;          // delay that the law gets for it
  double stiffness = 0;     // N/m in use
  double force = 0;         // N; on our instance
  double its_force = 0;     // N; on its instance, as it says
  double tank = 0;          // J; tank of our gate
  bool clipped = false;     // the gate holds the copy back
  double disagreement = 0;  // |own + its| / the larger, of the link's two wrenches; 0 at rest
};

}  // namespace tandem
