#pragma once

#include <atomic>
#include <optional>
#include <span>
#include <vector>

#include "collab/coupling/echoes.h"
#include "collab/coupling/shared_body.h"
#include "collab/mirror/remote_bodies.h"
#include "collab/ownership/holdings.h"
#include "collab/peer/frame_tap.h"
#include "collab/receive/peer_inbox.h"
#include "collab/receive/sample_gate.h"
#include "collab/separation/parting.h"
#include "collab/session/command.h"
#include "collab/session/frame_limits.h"
#include "collab/session/outbox.h"
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
  SharedBody::Options coupling;
  MirrorModel mirror = MirrorModel::kBlend;  // other models are for the lab
  double capacity = kDefaultCapacity;        // point tests that fit into a frame (paper §5)
  double look_price = kDefaultLookPrice;     // price of an exact look, in point tests
  std::size_t trace_frames = 0;              // frames to trace from the hand's start; 0: none
  FrameTap* tap = nullptr;                   // receives every frame's inputs; must outlive the peer
};

/// One frame for the report: motion of the held body, and the force felt.
struct TraceSample {
  std::int64_t time_ns = 0;
  Pose X_WB;
  Twist V_WB;
  float hand_force = 0;  // N; of the hand's coupling
  int contact_points = 0;
  bool loaded = false;  // contact pushes
};

/// Forces given to a device.
struct Felt {
  Wrench F_D_W;            // wrench in the last frame
  double peak_force = 0;   // N
  double peak_moment = 0;  // N m
  double peak_step = 0;    // N; greatest change from one frame to the next
};

/// Figures of the hand since it began, over all frames with a body in it.
struct HandFigures {
  std::int64_t frames = 0;
  std::int64_t frames_in_contact = 0;
  std::int64_t contact_points = 0;  // sum over all frames
  int most_contact_points = 0;
  double peak_force = 0;  // N; of the hand's coupling
  FrameLimits limits;
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
  /// The trace so far. Any thread may read it while the haptic thread goes on.
  std::span<const TraceSample> trace() const noexcept {
    return {trace_.data(), traced_.load(std::memory_order_acquire)};
  }
  const HandFigures& hand_figures() const noexcept { return hand_figures_; }
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
  const Holdings& holdings() const noexcept { return holdings_; }
  /// The guard between the simulation and the hand.
  const ForceGuard& guard() const noexcept { return guard_; }
  /// Counts of the actions of this guard and of the device's own; for callers in the same thread.
  SafetyCounts safety_counts() const noexcept;
  /// The reason why the hand's force is held back; the device's own guard comes first.
  SafetyState safety_state() const noexcept;
  /// The forces given to the device in the last frame, and the peaks so far.
  const Felt& felt() const noexcept { return felt_; }
  /// Frames in which a pair had more contacts than there is room for: some of them did not push.
  std::uint64_t crowded_frames() const noexcept { return crowded_frames_; }
  /// Number and length of the waits for voxels. Read it after the last frame.
  const VoxelWaits& voxel_waits() const noexcept { return voxel_waits_; }
  /// Returns whether the wait for voxels has been so long (kLongestVoxelWait) that the simulation
  /// is to end. Any thread.
  bool voxels_lack() const noexcept { return voxels_lack_.load(std::memory_order_relaxed); }
  /// The separation of our instance of the body in hand from the others'.
  const Parting& parting() const noexcept { return parting_; }

  /// The user's orders; pushed by one other thread.
  SpscQueue<Command>& commands() noexcept { return commands_; }
  /// Further messages that the sender thread is to publish, each of them.
  SpscQueue<Event>& events() noexcept { return events_; }
  SpscQueue<ObjectState>& parked() noexcept { return parked_; }
  /// For the control thread.
  TripleBuffer<ClaimList>& claims() noexcept { return claims_; }
  TripleBuffer<PeerTable>& table() noexcept { return table_; }
  SpscQueue<HoldingNews>& news() noexcept { return news_; }

  /// Hands on all bodies that this peer answers for; after the last frame.
  void Leave(std::int64_t now_ns) noexcept;

 private:
  /// Reads the handle. After an implausible reading it stays where it was, at rest; before any
  /// plausible reading it is at NaN.
  Anchor ReadDevice() noexcept;
  void Receive(std::int64_t now_ns) noexcept;
  void OnMembership(const MembershipChange& change) noexcept;
  void OnState(const ObjectState& state) noexcept;
  void OnEvent(const Event& event) noexcept;
  void OnCommand(const Command& command) noexcept;
  void SeeBodies() noexcept;
  /// Tells the holdings which free bodies the body in hand pushed in the last frame.
  void SeeTouches() noexcept;
  /// Runs the time-outs of the holdings and queues their events and news.
  void TickHoldings(std::int64_t now_ns) noexcept;
  /// Makes the hand hold the body that the holdings say.
  void TakeAndLetGo() noexcept;
  void Attach(const Anchor& goal) noexcept;
  void CountLimits() noexcept;
  /// The newest frame limits of a peer, as it said.
  struct HeardLimits {
    PeerId peer = 0;
    std::uint32_t flags = 0;
  };
  void NoteLimits(const ObjectState& state) noexcept;
  /// Couples the body in hand to its instance at `peer`; reports once if there is no place.
  void Couple(PeerId peer) noexcept;
  /// Couples the holders that found no place, as soon as there is one.
  void CoupleTheRest() noexcept;
  /// Gives the device the reaction of the body, as far as the guard lets it through.
  void Render() noexcept;
  /// Returns whether this peer simulates a free body in this frame: it answers for the body, and no
  /// hand has it. A body that fell out of the scene stands, and all do while the peer listens.
  bool IsSimulatedLoose(std::size_t body) const noexcept;
  void PrepareLoose() noexcept;
  /// Puts bodies that no peer moves where their authority says.
  void PrepareParked() noexcept;
  void SayParked(std::int64_t now_ns) noexcept;
  /// Sends the next of the loose bodies here.
  void SayLoose(std::int64_t now_ns, Outbox& out) noexcept;
  /// Returns whether a body that this peer simulates in no hand has moved lately.
  bool IsLoose(std::size_t body, std::int64_t now_ns) const noexcept;
  void FillView(std::int64_t now_ns, ViewFrame& view) const noexcept;
  /// Fills the table of the other peers.
  void FillTable(std::int64_t now_ns) noexcept;
  void StartWhenReady(std::int64_t now_ns) noexcept;
  void FillOutbox(std::int64_t now_ns, Outbox& out) noexcept;
  void Record(std::int64_t now_ns) noexcept;
  std::uint64_t StateHash() const noexcept;

  World* world_;
  Device* device_;
  PeerInbox* inbox_;
  PeerOptions options_;
  Holdings holdings_;
  int held_ = -1;          // body in hand, into the world's moving bodies; -1: none
  bool attached_ = false;  // the hand has grasped it
  Pose X_BD_;              // grasp of the hand on it
  std::int64_t nearing_frames_ = 0;
  std::optional<SharedBody> shared_;
  std::array<PeerId, kMaxPeers> uncoupled_{};  // holders without a place; 0: none
  double last_delay_s_ = 0;                    // mean_delay_s() of the body last let go of
  Parting parting_;
  RemoteBodies remote_;
  SampleGate gate_;
  DeviceCapabilities device_can_;
  bool stop_pressed_ = false;  // at the device, in the last frame
  ForceGuard guard_;
  Felt felt_;
  std::uint64_t crowded_frames_ = 0;
  VoxelWaits voxel_waits_;
  int waited_ = 0;  // frames, as in the last report
  std::atomic<bool> voxels_lack_{false};
  FrameLimitCount limits_;       // over all frames
  FrameLimitCount hand_limits_;  // over the frames of HandFigures
  std::array<HeardLimits, kMaxPeers> heard_limits_{};
  std::size_t next_heard_ = 0;  // place that is overwritten next
  Anchor handle_;               // the device's handle, as last read
  Echoes echoes_;
  StepInputs inputs_;
  StepReport report_;
  SpscQueue<Command> commands_{64};
  SpscQueue<Event> events_{256};
  SpscQueue<ObjectState> parked_{512};
  SpscQueue<HoldingNews> news_{64};
  TripleBuffer<ClaimList> claims_;
  TripleBuffer<PeerTable> table_;
  std::vector<std::int64_t> next_parked_ns_;  // per moving body
  struct FreeBody {
    bool ours = false;          // in the last frame, in our hand or loose here
    std::int64_t moved_ns = 0;  // when it last moved, loose here; 0: it does not
  };
  std::vector<FreeBody> free_;  // per moving body, free or not
  std::size_t next_loose_ = 0;
  std::uint32_t seq_ = 0;
  std::optional<std::int64_t> started_ns_;
  std::vector<TraceSample> trace_;  // full size from the start
  std::atomic<std::size_t> traced_ = 0;
  HandFigures hand_figures_;
};

}  // namespace tandem
