#pragma once

#include "collab/separation/pose_history.h"
#include "engine/dynamics/virtual_coupling.h"

namespace tandem {

/// Leads an instance back to another one from which something fixed separates it (paper §6.1; no
/// straight line leads there). It goes back along its own path to the last moment at which the two
/// were together, or if they never were, could meet along a straight line. Then it goes along the
/// other's path to the other. The same body went both paths, so nothing fixed is in the way;
/// contact forces stay on all the same. Used by the haptic thread alone; nothing allocates.
class ReturnPath {
 public:
  static constexpr double kTogether = 0.03;  // m
  static constexpr double kTogetherAngle = 0.5;
  static constexpr double kSpeed = 0.25;      // m/s, at the fastest surface point
  static constexpr double kLead = 0.01;       // m; most lead of the goal over the body
  static constexpr double kThere = 0.015;     // m from the other instance: arrived
  static constexpr int kStuckFrames = 3000;   // frames without progress of the goal
  static constexpr int kMostFrames = 15'000;  // frames of the whole way
  static constexpr int kMostMoments = 64;     // moments of the history examined in a frame

  /// kSearching: Search() goes on; kNoWay: at no kept moment did a straight line join the two;
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

  /// Begins the search for a way to `towards`. `radius`: radius of the body, m.
  void Start(const PoseHistory& history, PeerId towards, double radius) noexcept;
  void Stop() noexcept { state_ = State::kIdle; }
  /// Searches for a frame: some moments further back.
  void Search(const PoseHistory& history) noexcept;
  /// Sets out on the way that was found, from the present pose of our instance.
  void SetOut(const PoseHistory& history, const Pose& X_WB) noexcept;
  /// Advances by a frame; `X_WB`: the present pose of our instance.
  void Advance(const PoseHistory& history, const Pose& X_WB) noexcept;

  State state() const noexcept { return state_; }
  PeerId towards() const noexcept { return towards_; }
  /// The pose to which the body is drawn.
  const Pose& goal() const noexcept { return goal_; }

 private:
  /// The next pose of the way; null: the other is not heard any more, or the history ends.
  const Pose* Next(const PoseHistory& history) const noexcept;
  double Travel(const Pose& from, const Pose& to) const noexcept;

  State state_ = State::kIdle;
  PeerId towards_ = 0;
  double radius_ = 0;
  std::int64_t sought_ = 0;    // moment examined next
  std::int64_t free_run_ = 0;  // free moments directly before it
  bool back_ = true;           // on our own path
  std::int64_t moment_ = 0;    // next moment of the way
  std::int64_t together_ = 0;  // moment at which the way changes to the other's path; -1: not known
  Pose goal_;
  int frames_ = 0;  // frames on the way
  int stuck_frames_ = 0;
};

/// Returns the gains that draw a body of that inertia along: 800 N/m, damping ratio 0.7.
CouplingGains ReturnPathGains(const Inertia& inertia) noexcept;

}  // namespace tandem
