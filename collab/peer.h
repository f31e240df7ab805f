#pragma once

#include <atomic>
#include <optional>
#include <span>
#include <vector>

#include "collab/command.h"
#include "collab/echoes.h"
#include "collab/frame_limits.h"
#include "collab/frame_tap.h"
#include "collab/holdings.h"
#include "collab/outbox.h"
#include "collab/parting.h"
#include "collab/peer_inbox.h"
#include "collab/peer_table.h"
#include "collab/remote_bodies.h"
#include "collab/sample_gate.h"
#include "collab/shared_body.h"
#include "engine/haptics/device.h"
#include "engine/realtime/triple_buffer.h"
#include "engine/safety/force_guard.h"
#include "engine/world/world.h"

namespace tandem {

struct PeerOptions {
  PeerId id = 0;
  int held_object = -1;        // number in the scene of the body to take in hand first; -1: none
  Pose X_BD;                   // where the hand grasps that one; others where they are when taken
  std::int64_t settle_ns = 0;  // how long to listen before taking what nobody seems to hold
  bool own_only = false;       // takes no shared body: its force parameters are not the others'
  std::size_t wait_for = 0;    // other users whose loop must be closed before the hand starts
  SharedBody::Options coupling;
  MirrorModel mirror = MirrorModel::kBlend;  // others: for the lab
  double capacity = kDefaultCapacity;        // point tests that fit into a frame (paper §5)
  double look_price = kDefaultLookPrice;     // of an exact look, in point tests
  std::size_t trace_frames = 0;              // traced, from the hand's start; 0: none
  FrameTap* tap = nullptr;                   // gets every frame's inputs; must outlive the peer
};

/// What a frame leaves for the report: the held body's motion, and what was felt.
struct TraceSample {
  std::int64_t time_ns = 0;
  Pose X_WB;
  Twist V_WB;
  float hand_force = 0;  // N, of the hand's coupling
  int contact_points = 0;
  bool loaded = false;  // contact pushes
};

/// What a device was given.
struct Felt {
  Wrench F_D_W;            // in the last frame
  double peak_force = 0;   // N
  double peak_moment = 0;  // N m
  double peak_step = 0;    // N, from one frame to the next
};

/// What the hand went through since it began, over all frames with a body in it.
struct HandFigures {
  std::int64_t frames = 0;
  std::int64_t frames_in_contact = 0;
  std::int64_t contact_points = 0;  // over all frames
  int most_contact_points = 0;
  double peak_force = 0;  // N, of the hand's coupling
  FrameLimits limits;
};

/// The haptic half of a peer: device, simulation and the couplings to the others, as one state
/// machine that is fed with the time and with messages, and reads no clock. The same code runs over
/// DDS at 1 kHz and on the simulated network in virtual time. Used by the haptic thread alone;
/// Tick() does not allocate, lock or throw.
class Peer {
 public:
  Peer(World& world, Device& device, PeerInbox& inbox, const PeerOptions& options);

  /// One frame at `now_ns`: takes what is due, reads the device, steps the world, renders, fills
  /// `out`.
  void Tick(std::int64_t now_ns, Outbox& out) noexcept TANDEM_RUNS_ON(kHapticThread);

  /// nCapacity from the next frame on, in place of that of the options (paper §5).
  void SetCapacity(double tests) noexcept { inputs_.capacity = tests; }

  /// Whether the hand has begun, and when (ns).
  std::optional<std::int64_t> started_ns() const noexcept { return started_ns_; }
  /// Returns what is traced so far. Any thread may read it while the haptic thread goes on.
  std::span<const TraceSample> trace() const noexcept {
    return {trace_.data(), traced_.load(std::memory_order_acquire)};
  }
  const HandFigures& hand_figures() const noexcept { return hand_figures_; }
  /// Half the loop age, mean since the loop closed, s.
  double mean_delay_s() const noexcept { return shared_ ? shared_->mean_delay_s() : last_delay_s_; }
  /// The present pose of the held body, for those in the same thread.
  const RigidState* held_state() const noexcept;
  const StepReport& report() const noexcept { return report_; }
  /// Whether the hand has grasped what it holds, and there where (the device's place in the body).
  bool attached() const noexcept { return attached_; }
  const Pose& grasp() const noexcept { return X_BD_; }
  /// The farthest that a mirror is from the pose that was received of it, m.
  double mirror_lag_m() const noexcept { return remote_.mirror_lag_m(); }
  /// The couplings of the body in hand; null: it is not shared.
  const SharedBody* shared() const noexcept { return shared_ ? &*shared_ : nullptr; }
  const Holdings& holdings() const noexcept { return holdings_; }
  /// What stands between the simulation and the hand.
  const ForceGuard& guard() const noexcept { return guard_; }
  /// How often that and the device's own guard acted; for those in the same thread.
  SafetyCounts safety_counts() const noexcept;
  /// What holds the hand's force back, the device's own guard first.
  SafetyState safety_state() const noexcept;
  /// What the device was given in the last frame, and at the most so far.
  const Felt& felt() const noexcept { return felt_; }
  /// Frames in which a pair had more contacts than there is room for: some of them did not push.
  std::uint64_t crowded_frames() const noexcept { return crowded_frames_; }
  /// Counts how often and how long voxels were waited for. Read it after the last frame.
  const VoxelWaits& voxel_waits() const noexcept { return voxel_waits_; }
  /// Tells whether voxels were waited for for so long (kLongestVoxelWait) that the simulation is to
  /// end. Any thread.
  bool voxels_lack() const noexcept { return voxels_lack_.load(std::memory_order_relaxed); }
  /// What is between our instance of it and the others'.
  const Parting& parting() const noexcept { return parting_; }

  /// What the user asks for; pushed by one other thread.
  SpscQueue<Command>& commands() noexcept { return commands_; }
  /// What the sender thread is to publish beside the outbox, each.
  SpscQueue<Event>& events() noexcept { return events_; }
  SpscQueue<ObjectState>& parked() noexcept { return parked_; }
  /// For the control thread.
  TripleBuffer<ClaimList>& claims() noexcept { return claims_; }
  TripleBuffer<PeerTable>& table() noexcept { return table_; }
  SpscQueue<HoldingNews>& news() noexcept { return news_; }

  /// Hands on all that we answer for; after the last frame.
  void Leave(std::int64_t now_ns) noexcept;

 private:
  /// Where the handle is; one that says nonsense is where it was, at rest: at NaN, if never sound.
  Anchor ReadDevice() noexcept;
  void Receive(std::int64_t now_ns) noexcept;
  void OnMembership(const MembershipChange& change) noexcept;
  void OnState(const ObjectState& state) noexcept;
  void OnEvent(const Event& event) noexcept;
  void OnCommand(const Command& command) noexcept;
  void SeeBodies() noexcept;
  /// Tells the holdings which free bodies our part pushed in the last frame.
  void SeeTouches() noexcept;
  /// Time-outs of the holdings; what they have to say goes into the queues.
  void TickHoldings(std::int64_t now_ns) noexcept;
  /// Makes the hand hold what the holdings say, once it is where it is known to be.
  void TakeAndLetGo() noexcept;
  void Attach(const Anchor& goal) noexcept;
  void CountLimits() noexcept;
  /// The newest that a peer said of its own.
  struct HeardLimits {
    PeerId peer = 0;
    std::uint32_t flags = 0;
  };
  void NoteLimits(const ObjectState& state) noexcept;
  /// Couples what we hold to its instance at `peer`; where there is no place, says so once.
  void Couple(PeerId peer) noexcept;
  /// Those that found no place, as soon as there is one.
  void CoupleTheRest() noexcept;
  /// Gives the device what the body received, as far as the guard lets it through.
  void Render() noexcept;
  /// Tells whether this peer simulates a free body in this frame: it answers for the body, and
  /// nobody has it in hand. A body that fell out of the scene stands, and all do while the peer
  /// listens.
  bool IsSimulatedLoose(std::size_t body) const noexcept;
  void PrepareLoose() noexcept;
  /// Bodies that nobody moves stand where their authority says.
  void PrepareParked() noexcept;
  void SayParked(std::int64_t now_ns) noexcept;
  /// The next of the loose bodies here.
  void SayLoose(std::int64_t now_ns, Outbox& out) noexcept;
  /// Tells whether a body that this peer simulates in nobody's hand has moved lately.
  bool IsLoose(std::size_t body, std::int64_t now_ns) const noexcept;
  void FillView(std::int64_t now_ns, ViewFrame& view) const noexcept;
  /// What we know of the others, for those who look.
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
  int held_ = -1;          // into the world's moving bodies: in hand
  bool attached_ = false;  // the hand has grasped it
  Pose X_BD_;              // there
  std::int64_t nearing_frames_ = 0;
  std::optional<SharedBody> shared_;
  std::array<PeerId, kMaxPeers> uncoupled_{};  // holders that found no place; 0: none
  double last_delay_s_ = 0;                    // mean_delay_s() of the body let go
  Parting parting_;
  RemoteBodies remote_;
  SampleGate gate_;
  DeviceCapabilities device_can_;
  bool stop_pressed_ = false;  // at the device, a frame ago
  ForceGuard guard_;
  Felt felt_;
  std::uint64_t crowded_frames_ = 0;
  VoxelWaits voxel_waits_;
  int waited_ = 0;  // frames, as of the last one's report
  std::atomic<bool> voxels_lack_{false};
  FrameLimitCount limits_;       // of all frames
  FrameLimitCount hand_limits_;  // of those that HandFigures are of
  std::array<HeardLimits, kMaxPeers> heard_limits_{};
  std::size_t next_heard_ = 0;  // gives way to another peer
  Anchor handle_;               // of the device, as last read
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
    bool ours = false;          // in the last frame, in our hand or loose
    std::int64_t moved_ns = 0;  // when it last moved, loose here; 0: it does not
  };
  std::vector<FreeBody> free_;  // per moving body, free or not
  std::size_t next_loose_ = 0;
  std::uint32_t seq_ = 0;
  std::optional<std::int64_t> started_ns_;
  std::vector<TraceSample> trace_;  // all there is room for
  std::atomic<std::size_t> traced_ = 0;
  HandFigures hand_figures_;
};

}  // namespace tandem
