#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "collab/coupling/round_trip_tracker.h"
#include "collab/coupling/shared_body.h"
#include "collab/mirror/remote_bodies.h"
#include "collab/ownership/ownership.h"
#include "collab/separation/instance_separation.h"
#include "collab/session/drop_counts.h"
#include "collab/session/frame_limits.h"
#include "collab/session/messages.h"
#include "collab/session/peer_map.h"
#include "collab/session/peer_table.h"
#include "engine/realtime/triple_buffer.h"
#include "engine/world/world.h"

namespace tandem {

/// One frame for the report: motion of the held body, and the force felt.
struct TraceSample {
  std::int64_t time_ns = 0;
  Pose X_WB;
  Twist V_WB;
  float hand_force = 0;  // N; of the hand's coupling
  int contact_points = 0;
  bool pushing = false;  // contact pushes
};

/// Forces given to a device.
struct RenderedForces {
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

/// Everything that a peer shows of its frames: to its own program, to other peers and to viewers.
/// It reads the parts of the peer and changes none of them. Written by the haptic thread alone,
/// which never allocates here; each function says which other threads may read.
class PeerTelemetry {
 public:
  /// The parts of the peer that are shown. They outlive the telemetry.
  struct Parts {
    PeerId id;
    const World& world;
    const StepInputs& inputs;
    const StepReport& report;
    const Ownership& ownership;
    const RemoteBodies& remote;
    const RoundTripTracker& round_trips;
    const InstanceSeparation& separation;
    const DropTable& drops;
  };
  /// The body in the user's hand; -1 and null without one.
  struct InHand {
    int body = -1;
    const SharedBody* shared = nullptr;  // couplings of a shared body
  };

  /// `trace_frames`: length of the trace; 0: no trace.
  PeerTelemetry(const Parts& parts, std::size_t trace_frames);

  /// The events of a frame that the peer acts on.
  struct FrameEvents {
    bool voxels_came = false;    // the frame is the first after a wait for voxels
    bool first_crowded = false;  // contacts exceed their room for the first time
  };
  /// Counts what the last step gave up.
  FrameEvents CountStep() noexcept;
  /// Counts a wrench that the device got.
  void CountForce(const Wrench& given) noexcept;
  /// Notes which limits another peer's frames met, as its state says.
  void NoteLimits(const ObjectState& state) noexcept;
  /// Adds a frame of the started hand to its figures and to the trace.
  void RecordHand(std::int64_t now_ns, int body) noexcept;
  /// Writes the frame that viewers get.
  void FillView(std::int64_t now_ns, std::uint32_t seq, const InHand& hand,
                ViewFrame& view) const noexcept;
  /// Publishes the table of the other peers.
  void PublishTable(std::int64_t now_ns, const SharedBody* shared) noexcept;

  /// The bits that the held body's state carries of the frames of the last second. Haptic thread
  /// alone.
  std::uint32_t limit_flags() const noexcept { return AsFlags(limits_.last()); }
  /// The trace so far. Any thread may read it while the haptic thread goes on.
  std::span<const TraceSample> trace() const noexcept {
    return {trace_.data(), traced_.load(std::memory_order_acquire)};
  }
  /// The hand's figures so far. Haptic thread; any thread after the last frame.
  const HandFigures& hand_figures() const noexcept { return hand_figures_; }
  /// The forces given to the device in the last frame, and the peaks so far. Haptic thread; any
  /// thread after the last frame.
  const RenderedForces& rendered() const noexcept { return rendered_; }
  /// Frames in which a pair had more contacts than there is room for: some of them did not push.
  /// Haptic thread; any thread after the last frame.
  std::uint64_t crowded_frames() const noexcept { return crowded_frames_; }
  /// Number and length of the waits for voxels. Read it after the last frame.
  const VoxelWaits& voxel_waits() const noexcept { return voxel_waits_; }
  /// Returns whether the wait for voxels has been so long (kLongestVoxelWait) that the simulation
  /// is to end. Any thread.
  bool voxels_missing() const noexcept { return voxels_missing_.load(std::memory_order_relaxed); }
  /// For the control thread.
  TripleBuffer<PeerTable>& table() noexcept { return table_; }

 private:
  /// The newest frame limits of another peer.
  struct ReceivedLimits {
    PeerId peer = 0;
    std::uint32_t flags = 0;
  };
  void FillRow(const RoundTripTracker::Loop& loop, std::span<const LinkView> links,
               PeerTableRow& row) const noexcept;
  void AddBody(std::size_t body, std::uint32_t flags, const Vec3& hand_force_W,
               ViewFrame& view) const noexcept;
  /// Adds the bodies that stand where this peer says; `held` is not among them.
  void AddStanding(std::int64_t now_ns, int held, ViewFrame& view) const noexcept;

  Parts parts_;
  RenderedForces rendered_;
  std::uint64_t crowded_frames_ = 0;
  VoxelWaits voxel_waits_;
  int waited_ = 0;  // frames, as in the last report
  std::atomic<bool> voxels_missing_{false};
  FrameLimitCount limits_;       // over all frames
  FrameLimitCount hand_limits_;  // over the frames of HandFigures
  PeerMap<ReceivedLimits, kMaxPeers> received_limits_;
  std::size_t next_received_ = 0;  // slot of the limits that give way next, where all are in use
  HandFigures hand_figures_;
  std::vector<TraceSample> trace_;  // full size from the start
  std::atomic<std::size_t> traced_ = 0;
  TripleBuffer<PeerTable> table_;
};

}  // namespace tandem
