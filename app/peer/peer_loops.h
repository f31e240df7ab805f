#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "app/capacity/capacity_follower.h"
#include "app/judgement/judged_frames.h"
#include "app/judgement/verdict.h"
#include "app/peer/peer_control.h"
#include "app/peer/session_setup.h"
#include "engine/base/thread_roles.h"
#include "engine/realtime/periodic_thread.h"
#include "engine/realtime/spsc_queue.h"

namespace tandem {

/// A peer's haptic thread and its sender. The haptic thread says when it has begun and when it has
/// done its frames. It goes on until it is stopped, because other peers still feel its instance.
/// The control thread calls the functions.
class PeerLoops {
 public:
  /// Starts both threads. `control`: null: the peer is no controller.
  PeerLoops(const PeerArguments& arguments, const SessionSetup& setup, PeerControl* control);

  const RealtimeStatus& realtime() const noexcept { return haptic_.realtime(); }
  bool begun() const noexcept { return begun_.load(std::memory_order_relaxed); }
  bool done() const noexcept { return done_.load(std::memory_order_acquire); }
  /// Returns whether the hand has held a body.
  bool holds() const noexcept { return holds_.load(); }
  /// Takes the poses of the body in hand since the last call.
  void TakePoses(HeldPoses& poses);

  /// These stop the thread and wait for its end.
  void EndHaptic();
  void EndSender();

  /// These are read once the haptic thread has ended.
  const FrameStats& stats() const { return haptic_.stats(); }
  const JudgedFrames& judged() const noexcept { return judged_; }
  const TouchedBodies& met() const noexcept { return met_; }

 private:
  void Frame(std::int64_t now_ns) TANDEM_RUNS_ON(kHapticThread);
  /// Notes the body in hand, and counts the frame, once the hand has begun.
  void SeeHand();
  void CountFrame(std::int64_t start_ns, std::int64_t end_ns, std::int64_t cpu_ns);

  PeerNode& node_;
  Transport& transport_;
  PeerControl* control_;
  std::atomic<bool> begun_{false};
  std::atomic<bool> done_{false};
  std::atomic<bool> holds_{false};  // the hand holds a body
  const std::int64_t frames_;       // frames to do after the hand's start; 0: any number
  std::int64_t frames_since_start_ = 0;
  bool hand_moves_ = false;  // in the present frame of the haptic thread
  // follows the frames' times; nothing: the capacity stays as given
  std::optional<CapacityFollower> capacity_;
  SpscQueue<HeldPose> held_poses_;  // to the control thread, which takes them 50 times a second
  TouchedBodies met_;
  const std::int64_t origin_ns_;
  JudgedFrames judged_;
  PeriodicThread haptic_;
  // stops the haptic thread at a forced end, whatever the control thread is in
  const AtForcedEnd no_more_force_;
  PeriodicThread sender_;
};

}  // namespace tandem
