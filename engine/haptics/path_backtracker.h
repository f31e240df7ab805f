#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "engine/base/spatial.h"

namespace tandem {

/// Records the ways of a hand's parts, so that a part can be driven back along its own. There is a
/// stretch for each time that a part was taken, the newest on top. Going back takes poses off the
/// top. The class moves nothing itself: goal() is the pose to which a coupling pulls the part, at a
/// bounded speed and never far ahead of it. So contact stops the part as it stops a hand.
///
/// It keeps 16,384 poses, 1 mm of travel apart, and forgets the oldest first. A way of which a part
/// is forgotten is cut(). Going back then ends where the rest begins, which is not where the part
/// was taken. Used by the haptic thread alone; only the constructor allocates.
class PathBacktracker {
 public:
  static constexpr double kStep = 1e-3;   // travel from one pose to the next, m
  static constexpr double kSpeed = 0.25;  // speed of the fastest surface point, m/s
  static constexpr double kLead = 0.01;   // greatest lead of the goal over the part, m
  /// Distance from the way's beginning at which the part has arrived, m.
  static constexpr double kSettled = 3e-4;
  static constexpr double kThere = 2e-3;  // the same after kSettleFrames there, m
  static constexpr int kSettleFrames = 500;
  /// Distance from the way's end, m, at which another hand has moved the part.
  static constexpr double kAway = 0.01;
  static constexpr int kStuckFrames = 2000;    // frames without a step of the goal
  static constexpr std::size_t kMost = 16384;  // poses
  static constexpr std::size_t kMostStretches = 256;

  /// kNotHere: the part is not where its way ends. kCut: the part is where the rest of its way
  /// begins.
  enum class State : std::uint8_t { kIdle, kUnderWay, kArrived, kStuck, kNotHere, kCut };

  PathBacktracker();

  /// Begins a new stretch: a hand takes the part. `radius`: of the part, m.
  void Begin(int body, double radius, const Pose& X_WB) noexcept;
  /// Notes where the part of the newest stretch is, as its hand moves it.
  void Note(const Pose& X_WB) noexcept;
  /// Tells whether the beginning of the newest stretch is forgotten.
  bool cut() const noexcept { return stretch_count_ > 0 && top().first < oldest_; }
  /// Returns the part of the newest stretch; -1: there is none.
  int body() const noexcept { return stretch_count_ == 0 ? -1 : top().body; }
  /// Forgets the newest stretch.
  void Drop() noexcept;

  /// Starts the goal at `X_WB`, on its way back to the beginning of the newest stretch.
  void SetOut(const Pose& X_WB) noexcept;
  /// Advances the goal by a frame. `X_WB`: pose of the part.
  void Advance(const Pose& X_WB) noexcept;
  void Stop() noexcept { state_ = State::kIdle; }

  State state() const noexcept { return state_; }
  /// Returns the pose to which the part is to be drawn.
  const Pose& goal() const noexcept { return goal_; }

 private:
  struct Stretch {
    int body = -1;
    double radius = 0;
    std::uint64_t first = 0;  // index into the poses
  };
  struct Poses {
    std::array<Pose, kMost> at;
  };
  Stretch& top() noexcept { return stretches_[(stretch_end_ - 1) % kMostStretches]; }
  const Stretch& top() const noexcept { return stretches_[(stretch_end_ - 1) % kMostStretches]; }
  Pose& pose(std::uint64_t number) noexcept { return poses_->at[number % kMost]; }
  /// Returns the first pose of the newest stretch that is not forgotten.
  std::uint64_t first() const noexcept;
  void Push(const Pose& X_WB) noexcept;
  double Travel(const Pose& from, const Pose& to) const noexcept;

  std::unique_ptr<Poses> poses_;
  std::uint64_t end_ = 0;     // number of the next pose
  std::uint64_t oldest_ = 0;  // number of the oldest pose that is not overwritten, whatever end_ is
  std::array<Stretch, kMostStretches> stretches_{};
  std::uint64_t stretch_end_ = 0;
  std::size_t stretch_count_ = 0;
  State state_ = State::kIdle;
  Pose goal_;
  int waited_ = 0;  // frames since the goal's last step
};

}  // namespace tandem
