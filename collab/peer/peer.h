#pragma once

#include <atomic>
#include <optional>
#include <span>
#include <vector>

#include "collab/coupling/round_trip_tracker.h"
#include "collab/coupling/shared_body.h"
#include "collab/mirror/remote_bodies.h"
#include "collab/ownership/ownership.h"
#include "collab/peer/frame_observer.h"
#include "collab/peer/peer_telemetry.h"
#include "collab/receive/peer_inbox.h"
#include "collab/receive/sample_validator.h"
#include "collab/separation/instance_separation.h"
#include "collab/session/command.h"
#include "collab/session/frame_limits.h"
#include "collab/session/outbox.h"
#include "collab/session/peer_map.h"
#include "collab/session/peer_table.h"
#include "engine/haptics/device.h"
#include "engine/realtime/triple_buffer.h"
#include "engine/safety/force_guard.h"
#include "engine/world/world.h"

namespace tandem {

struct PeerOptions {
  PeerId id = 0;
  int held_object = -1;  // scene number of the body to take in hand first; -1: none
  Pose X_BD;  // grasp on that body; the hand grasps other bodies where they are when taken
  std::int64_t settle_ns = 0;  // time to listen before taking bodies that no peer seems to hold
  bool own_only = false;       // takes no shared body: the other peers have other force parameters
  std::size_t wait_for = 0;    // other users whose loop must be closed before the hand starts
  std::shared_ptr<const CouplingLaw> law = DefaultLaw();  // law of shared bodies' links
  ExperimentOptions experiments;                          // the product: contact and gate alone
  double capacity = kDefaultCapacity;       // point tests that fit into a frame (paper §5)
  double query_price = kDefaultQueryPrice;  // price of an exact query, in point tests
  std::size_t trace_frames = 0;             // frames to trace from the hand's start; 0: none
  FrameObserver* observer = nullptr;        // receives every frame's inputs; must outlive the peer
};

/// The haptic half of a peer: device, simulation and the couplings to other peers. A state machine
/// fed with the time and with messages; it reads no clock. The same code runs over DDS at 1 kHz and
/// on the simulated network in virtual time. Used by the haptic thread alone; Tick() does not
/// allocate, lock or throw.
class Peer {
 public:
  Peer(World& world, Device& device, PeerInbox& inbox, const PeerOptions& options);

  /// Runs one frame at `now_ns`: takes messages that are due, reads the device, steps the world,
  /// renders, fills `out`.
  void Tick(std::int64_t now_ns, Outbox& out) noexcept TANDEM_RUNS_ON(kHapticThread);

  /// Sets nCapacity from the next frame on, in place of that of the options (paper §5).
  void SetCapacity(double tests) noexcept { inputs_.capacity = tests; }

  /// When the hand began (ns); nullopt: it has not.
  std::optional<std::int64_t> started_ns() const noexcept { return started_ns_; }
  /// The figures and traces that the peer shows of its frames.
  const PeerTelemetry& telemetry() const noexcept { return telemetry_; }
  /// Half the loop age, mean since the loop closed, s.
  double mean_delay_s() const noexcept { return shared_ ? shared_->mean_delay_s() : last_delay_s_; }
  /// The present state of the held body, for callers in the same thread; null: none.
  const RigidState* held_state() const noexcept;
  const StepReport& report() const noexcept { return report_; }
  /// Returns whether the hand has grasped the held body; grasp() is the device's pose in it.
  bool attached() const noexcept { return attached_; }
  const Pose& grasp() const noexcept { return X_BD_; }
  /// The greatest distance of a mirror from its received pose, m.
  double mirror_lag_m() const noexcept { return remote_.mirror_lag_m(); }
  /// The couplings of the body in hand; null: it is not shared.
  const SharedBody* shared() const noexcept { return shared_ ? &*shared_ : nullptr; }
  const Ownership& ownership() const noexcept { return ownership_; }
  /// The guard between the simulation and the hand.
  const ForceGuard& guard() const noexcept { return guard_; }
  /// Counts of the actions of this guard and of the device's own; for callers in the same thread.
  SafetyCounts safety_counts() const noexcept;
  /// The reason why the hand's force is held back; the device's own guard comes first.
  SafetyState safety_state() const noexcept;
  /// The separation of our instance of the body in hand from the others'.
  const InstanceSeparation& separation() const noexcept { return separation_; }

  /// The user's orders; pushed by one other thread.
  SpscQueue<Command>& commands() noexcept { return commands_; }
  /// Further messages that the sender thread is to publish, each of them.
  SpscQueue<Event>& events() noexcept { return events_; }
  SpscQueue<ObjectState>& parked() noexcept { return parked_; }
  /// For the control thread.
  TripleBuffer<ClaimList>& claims() noexcept { return claims_; }
  TripleBuffer<PeerTable>& table() noexcept { return telemetry_.table(); }
  SpscQueue<Notification>& notifications() noexcept { return notifications_; }

  /// Hands on all bodies that this peer answers for; after the last frame.
  void Leave(std::int64_t now_ns) noexcept;

 private:
  /// Returns the number of moving bodies.
  std::size_t body_count() const noexcept { return world_->model().bodies.size(); }

  // the phases of a frame
  /// Takes what came since the last frame; the hand takes or lets go of its body accordingly.
  void Receive(std::int64_t now_ns) noexcept;
  /// Computes the frame: from the device's pose to the force that the device gets.
  void Simulate(std::int64_t now_ns) noexcept;
  /// Hands over what other peers, viewers and the peer's own program get of the frame.
  void Publish(std::int64_t now_ns, Outbox& out) noexcept;

  // parts of Receive()
  /// Takes the messages that are due and the user's commands.
  void TakeMessages(std::int64_t now_ns) noexcept;
  void OnMembership(const MembershipChange& change) noexcept;
  void OnState(const ObjectState& state) noexcept;
  void OnEvent(const Event& event) noexcept;
  void OnCommand(const Command& command) noexcept;
  void UpdateBodyPoses() noexcept;
  /// Tells Ownership which free bodies the body in hand pushed in the last frame.
  void NoteTouches() noexcept;
  /// Runs the time-outs of Ownership and queues their events and news.
  void TickOwnership(std::int64_t now_ns) noexcept;
  /// Makes the hand hold the body that Ownership names.
  void SyncHeldBody() noexcept;
  /// Couples the body in hand to its instance at `peer`; reports once if there is no place.
  void Couple(PeerId peer) noexcept;
  /// Couples the holders that found no place, as soon as there is one.
  void CoupleWaiting() noexcept;
  void StartWhenReady(std::int64_t now_ns) noexcept;

  // parts of Simulate()
  /// Reads the handle. After an implausible reading it stays where it was, at rest; before any
  /// plausible reading it is at NaN.
  Anchor ReadDevice() noexcept;
  /// Measures the ages of the loops to all peers, makes the held body one that this peer simulates,
  /// and sets the inputs of all bodies in no hand of this peer.
  void PrepareOthers(std::int64_t now_ns) noexcept;
  /// Returns whether this peer simulates a free body in this frame: it answers for the body, and no
  /// hand has it. A body that fell out of the scene stands, and all do while the peer listens.
  bool IsSimulatedLoose(std::size_t body) const noexcept;
  void PrepareLoose() noexcept;
  /// Puts bodies that no peer moves where their authority says.
  void PrepareParked() noexcept;
  /// Sets the inputs of the hand, of the body in it and of its links. `goal`: pose of the handle.
  void PrepareHand(std::int64_t now_ns, const Anchor& goal) noexcept;
  void Attach(const Anchor& goal) noexcept;
  /// Counts what the step gave up, and acts on it.
  void CountLimits() noexcept;
  /// Gives the device the reaction of the body, as far as the guard lets it through.
  void Render() noexcept;
  /// Clears wrenches of the report that no peer may get.
  void DiscardBadWrenches() noexcept;

  // parts of Publish()
  void FillOutbox(std::int64_t now_ns, Outbox& out) noexcept;
  /// Sends the next of the loose bodies here.
  void PublishLoose(std::int64_t now_ns, Outbox& out) noexcept;
  /// Returns whether a body that this peer simulates in no hand has moved lately.
  bool IsLoose(std::size_t body, std::int64_t now_ns) const noexcept;
  void PublishParked(std::int64_t now_ns) noexcept;

  std::uint64_t StateHash() const noexcept;

  World* world_;
  Device* device_;
  PeerInbox* inbox_;
  PeerOptions options_;
  Ownership ownership_;
  int held_ = -1;          // body in hand, into the world's moving bodies; -1: none
  bool attached_ = false;  // the hand has grasped it
  Pose X_BD_;              // grasp of the hand on it
  std::int64_t nearing_frames_ = 0;
  std::optional<SharedBody> shared_;
  PeerSet<kMaxPeers> uncoupled_;  // holders without a place
  double last_delay_s_ = 0;       // mean_delay_s() of the body last let go of
  InstanceSeparation separation_;
  RemoteBodies remote_;
  SampleValidator validator_;
  DeviceCapabilities device_can_;
  bool stop_pressed_ = false;  // at the device, in the last frame
  ForceGuard guard_;
  Anchor handle_;  // the device's handle, as last read
  RoundTripTracker round_trips_;
  StepInputs inputs_;
  StepReport report_;
  SpscQueue<Command> commands_{64};
  SpscQueue<Event> events_{256};
  SpscQueue<ObjectState> parked_{512};
  SpscQueue<Notification> notifications_{64};
  TripleBuffer<ClaimList> claims_;
  std::vector<std::int64_t> next_parked_ns_;  // per moving body
  struct FreeBody {
    bool ours = false;          // in the last frame, in our hand or loose here
    std::int64_t moved_ns = 0;  // when it last moved, loose here; 0: it does not
  };
  std::vector<FreeBody> free_;  // per moving body, free or not
  std::size_t next_loose_ = 0;
  std::uint32_t seq_ = 0;
  std::optional<std::int64_t> started_ns_;
  PeerTelemetry telemetry_;  // reads the members above
};

}  // namespace tandem
