#pragma once

#include "collab/pose_history.h"
#include "engine/dynamics/virtual_coupling.h"

namespace tandem {

/// The way by which an instance comes back to another's, from which something fixed parts it
/// (paper §6.1; no straight line leads there): back along our own path to the last moment at which
/// the two were together, then along the other's path to where it is. Both paths were gone by the
/// same body, so nothing fixed is in the way; the contact forces stay on all the same. Used by the
/// haptic thread alone; nothing allocates.
class Retrace {
 public:
  static constexpr double kTogether = 0.03;  // m
  static constexpr double kTogetherAngle = 0.5;
  static constexpr double kSpeed = 0.25;      // m/s, of the fastest surface point
  static constexpr double kLead = 0.01;       // m that the goal is ahead of the body at the most
  static constexpr double kThere = 0.015;     // m from the other: arrived
  static constexpr int kStuckFrames = 3000;   // without a step of the goal
  static constexpr int kMostFrames = 15'000;  // of the whole way
  static constexpr int kMostMoments = 64;     // of the history, looked at in a frame

  /// kSearching: Search() goes on; kNoWay: there was no moment at which they were together;
  /// kFound: SetOut() begins.
  enum class State : std::uint8_t {
    kIdle,
    kSearching,
    kNoWay,
    kFound,
    kUnderWay,
    kArrived,
    kStuck
  };

  /// Begins to look for a way to that one. `radius`: of the body, m.
  void Start(const PoseHistory& history, PeerId towards, double radius) noexcept;
  void Stop() noexcept { state_ = State::kIdle; }
  /// A frame of the search: some moments further back.
  void Search(const PoseHistory& history) noexcept;
  /// Takes the way that was found, from where our instance is now.
  void SetOut(const PoseHistory& history, const Pose& X_WB) noexcept;
  /// A frame on the way: where our instance is.
  void Advance(const PoseHistory& history, const Pose& X_WB) noexcept;

  State state() const noexcept { return state_; }
  PeerId towards() const noexcept { return towards_; }
  /// Where the body is to be drawn to now.
  const Pose& goal() const noexcept { return goal_; }

 private:
  /// The pose to go to next; null: the other is not heard any more, or the way is forgotten.
  const Pose* Next(const PoseHistory& history) const noexcept;
  double Travel(const Pose& from, const Pose& to) const noexcept;

  State state_ = State::kIdle;
  PeerId towards_ = 0;
  double radius_ = 0;
  std::int64_t sought_ = 0;    // moment to look at next
  std::int64_t free_run_ = 0;  // moments before it, all of them free
  bool back_ = true;           // on our own path
  std::int64_t moment_ = 0;    // to go to next
  std::int64_t together_ = 0;  // where our path is left for the other's; -1: not known
  Pose goal_;
  int frames_ = 0;  // on the way
  int stuck_frames_ = 0;
};

/// What draws a body of that inertia along: 800 N/m, hardly ringing.
CouplingGains RetraceGains(const Inertia& inertia) noexcept;

}  // namespace tandem
