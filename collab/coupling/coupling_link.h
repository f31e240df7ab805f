#pragma once

#include <cstdint>
#include <optional>

#include "collab/coupling/coupling_law.h"
#include "collab/coupling/delay_meter.h"
#include "collab/coupling/energy_gate.h"
#include "collab/coupling/link_views.h"
#include "collab/coupling/stiffness_limiter.h"
#include "collab/receive/sent_stamps.h"
#include "collab/session/messages.h"
#include "engine/base/experiment_options.h"
#include "engine/base/units.h"
#include "engine/world/step_inputs.h"

namespace tandem {

/// The own instance of a shared body in a frame.
struct LinkFrame {
  std::int64_t now_ns = 0;
  const RigidState& own;
  const Mat3& per_mass;  // rotational inertia in W over the mass, m^2
  ExperimentOptions experiments;
};

/// The stiffness that the links of a body share in a frame.
struct SharedStiffness {
  const CouplingLaw& law;
  const LawInputs& common;        // for the worst loop of the closed links
  LinkLaw allowed;                // law's link for these inputs
  double longest_loop_age_s = 0;  // greatest age of any link in the last minutes
  double most = 0;                // N/m; largest sum of stiffnesses
  double sum = 0;                 // N/m; over the closed links, as they change in the frame
  // a newcomer shares the sum of fewer links, and has nothing of it before these have less
  bool has_newcomer = false;
  // parts of a gentle change for one link: it is gentle in the sum over all links that the hand
  // feels, as when a cut takes or gives back all peers
  double falls_share = 1;
  double rises_share = 1;

  /// Returns the law's link for a loop that is older than that of all links.
  LinkLaw LinkAt(double loop_age_s) const noexcept;
};

/// This end of the link between the own instance of a shared body and another user's: the copy of
/// that instance, the spring and damper that pull the two together, and the loop over the network
/// that limits them. SharedBody has one for each coupled peer. Used by the haptic thread alone;
/// nothing allocates.
class CouplingLink {
 public:
  enum class State : std::uint8_t {
    kListening,    // the peer holds the body; it has not been heard, or has not heard us
    kRising,       // the loop is closed; the stiffness has yet to reach what the delay allows
    kEstablished,  // the stiffness has reached it
    kFading,       // the peer has let go of the body, and its pull goes away
  };

  /// Listens again while the pull fades: the peer is back, and the link goes on from there.
  void Rejoin() noexcept;
  /// Fades the pull over 200 ms, or longer: all links whose stiffness falls share 8 N/s.
  void Part() noexcept;
  /// Takes a state of the peer's instance, unless a newer one has come.
  void OnState(const ObjectState& state) noexcept;
  /// Takes the peer's entries for `self`. Returns how many echoes it refuses: stamps that are not
  /// in `sent`, or older than the last.
  std::size_t OnLinks(const CouplingLinks& links, PeerId self, const SentStamps& sent) noexcept;
  /// Limits the force from now on. A greater force falls gently, and the other end follows.
  void CapForce(double newtons) noexcept;
  /// Scales the force to `share` of what it was when the fade began, until the next CapForce().
  void FadeForce(double share) noexcept { force_limit_.share = share; }

  // The steps of a frame, in this order.

  /// Measures the age of the loop in this frame, and in the one before.
  void Measure(std::int64_t now_ns, std::int64_t last_frame_ns) noexcept;
  /// Adds energy (J) that drag took out of the body to the gate's tank.
  void Earn(double energy) noexcept { gate_.Credit(energy); }
  /// Moves the copy towards the newest state, as far as the force may change in a frame and as far
  /// as the gate's energy allows. The peer is heard.
  void MoveCopy(const LinkFrame& frame) noexcept;
  /// Changes the stiffness and the damping towards what the delay and the peer's offer allow, and
  /// their sum in `shared`. The peer is heard.
  void Slew(const LinkFrame& frame, SharedStiffness& shared) noexcept;
  /// Writes the copy and the gains for the step. The peer is heard.
  void Couple(const LinkFrame& frame, StepInputs::Link& link) noexcept;
  /// Notes the wrench on our instance, as the step applied it.
  void NoteApplied(const Wrench& F_B_W) noexcept { applied_B_W_ = F_B_W; }
  /// Returns the entry for the peer `to`. The peer is heard.
  LinkEntry Describe(PeerId to) const noexcept;

  State state() const noexcept { return state_; }
  /// Returns whether the loop is closed: the peer is heard, and has heard us.
  bool closed() const noexcept { return state_ == State::kRising || state_ == State::kEstablished; }
  /// Returns whether nothing is left of a pull that fades.
  bool over() const noexcept {
    return state_ == State::kFading && (!received() || stiffness_.in_use <= 0);
  }
  bool received() const noexcept { return instance_.state.has_value(); }
  /// The peer's newest state; null: none has come.
  const ObjectState* newest() const noexcept { return received() ? &*instance_.state : nullptr; }
  double stiffness() const noexcept { return stiffness_.in_use; }  // N/m
  bool falls() const noexcept { return stiffness_.in_use < stiffness_.last; }
  bool rises() const noexcept { return stiffness_.in_use > stiffness_.last; }
  /// The present age of the loop, s; 0: no echo has come since the peer joined.
  double loop_age_s(std::int64_t now_ns) const noexcept {
    return loop_.echo_ns ? ToSeconds(now_ns - *loop_.echo_ns) : 0.0;
  }
  /// The worst age of the loop in the past two seconds, s.
  double peak_loop_age_s() const noexcept { return loop_.meter.peak_loop_age_s(); }
  /// Returns the figures of the link to `peer`. `gyration`: the body's radius of gyration, m.
  LinkView View(PeerId peer, std::int64_t now_ns, double gyration) const noexcept;

 private:
  /// The peer's instance, as it was sent.
  struct Instance {
    std::optional<ObjectState> state;  // newest; none: the peer has not been heard
    bool is_fresh = false;             // it came since the last frame
    std::int64_t arrived_ns = 0;       // own clock; frame of its arrival; 0: none yet
  };
  /// The loop from our states to the echoes in the peer's links.
  struct Loop {
    std::optional<std::int64_t> echo_ns;  // newest own stamp that the peer has; none: no echo
    bool is_fresh = false;                // a newer echo came since the last frame
    std::int64_t measured_ns = 0;         // echo_ns in the last frame
    std::uint32_t links_seq = 0;          // number of the newest links
    DelayMeter meter;                     // ages at arrivals
  };
  struct Stiffness {
    double in_use = 0;   // N/m
    double last = 0;     // N/m; in use before the last frame's change
    double offered = 0;  // N/m; our offer
    double its = 0;      // N/m; the peer's offer
    double damping = 0;  // N s/m in use, on the velocity of the copy relative to the own instance
  };
  struct ForceLimit {
    double most = 1e30;    // N
    double share = 1;      // share of `from` allowed as the force; 1: no fade
    double from = 0;       // N; force when the fade began
    double part_rate = 0;  // N/m/s; fall of the stiffness after the peer has let go
  };
  /// The copy of the peer's instance at which the spring pulls.
  struct Copy {
    Pose X_WB;                       // pose that the gate has let through
    Twist V_WB;                      // twist as last used: 0 for a copy that stands
    double moving = 0;               // share of the peer's velocity in use: 0 for a silent peer
    bool is_catching_up = false;     // after a silence it moves slowly to the new pose
    double way_force = 0;            // N; change of the link's force by its move in this frame
    EnergyGate::Stretch stretch;     // from our instance to it, in this frame
    Vec3 turn_axis = Vec3::UnitX();  // axis of the turn from our instance to it
  };

  void Take(const LinkEntry& entry) noexcept;
  /// Goes on from listening when the peer is heard and has heard us.
  void CloseLoop() noexcept;
  /// Moves the copy's twist towards the peer's; the gate pays for what the damper gives.
  void MoveTwist(const LinkFrame& frame) noexcept;
  /// Returns how fast the stiffness may change, whatever is wanted of it.
  StiffnessLimiter LimitsOf(const LinkFrame& frame, const SharedStiffness& shared) const noexcept;
  /// Sets the stiffness that is offered over a closed loop, and the goal of `slew`. Returns the
  /// law's link.
  LinkLaw OfferTo(std::int64_t now_ns, const SharedStiffness& shared,
                  StiffnessLimiter& slew) noexcept;
  /// Notes whether the stiffness has reached its goal, N/m.
  void NoteReached(double goal) noexcept;

  State state_ = State::kListening;
  Instance instance_;
  Loop loop_;
  Stiffness stiffness_;
  ForceLimit force_limit_;
  Copy copy_;
  EnergyGate gate_;
  Wrench applied_B_W_;      // on our instance in the last frame
  Wrench its_applied_B_W_;  // on its instance, as it says

  // ExperimentOptions: this part of the class alone knows of them.

  /// Moves the copy to `next`, or as far on the way there as the gate's energy allows.
  void LetThrough(const Pose& next, const LinkFrame& frame) noexcept;
  /// Returns the energy that the gate can pay, J; without bound where there is no gate.
  double EnergyLeft(const LinkFrame& frame) const noexcept;
  /// Computes the force of this end, to be sent, and applies the other end's in its place. Does
  /// nothing where forces are not exchanged.
  void ExchangeForces(const LinkFrame& frame, StepInputs::Link& link) noexcept;

  /// Returns the wrench that the peer is told: as applied, or as computed where forces are
  /// exchanged.
  const Wrench& told_B_W() const noexcept { return computed_B_W_ ? *computed_B_W_ : applied_B_W_; }

  std::optional<Wrench> computed_B_W_;  // force of this end; none: forces are not exchanged
};

}  // namespace tandem
