#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "engine/base/spatial.h"

namespace tandem {

/// The ways that a hand's parts have come, so that a part can be driven back along its own: a
/// stretch for each time that a part was taken, the newest on top. Going back takes poses off the
/// top. It moves nothing itself: goal() is where a coupling is to pull the part, at a bounded speed
/// and never far ahead of it, so that contact stops the part as it stops a hand.
///
/// Of 16,384 poses, 1 mm of travel apart, the oldest are forgotten first: a way of which a part is
/// forgotten is cut(), and going back ends where the rest begins, which is not where the part was
/// taken. Used by the haptic thread
/// alone; nothing but the constructor allocates.
class WayBack {
 public:
  static constexpr double kStep = 1e-3;     // m of travel from one pose to the next
  static constexpr double kSpeed = 0.25;    // m/s, of the fastest surface point
  static constexpr double kLead = 0.01;     // m that the goal is ahead of the part at the most
  static constexpr double kSettled = 3e-4;  // m from the way's beginning: arrived
  static constexpr double kThere = 2e-3;    // m, after kSettleFrames there
  static constexpr int kSettleFrames = 500;
  static constexpr double kAway = 0.01;        // m from the way's end: somebody else has moved it
  static constexpr int kStuckFrames = 2000;    // without a step of the goal
  static constexpr std::size_t kMost = 16384;  // poses
  static constexpr std::size_t kMostStretches = 256;

  /// kNotHere: the part is not where its way ends. kCut: it is
  /// where what is left of its way begins.
  enum class State : std::uint8_t { kIdle, kUnderWay, kArrived, kStuck, kNotHere, kCut };

  WayBack();

  /// A hand takes the part: a new stretch. `radius`: of the part, m.
  void Begin(int body, double radius, const Pose& X_WB) noexcept;
  /// Where the part of the newest stretch is now, as its hand moves it.
  void Note(const Pose& X_WB) noexcept;
  /// Whether the beginning of the newest stretch is forgotten.
  bool cut() const noexcept { return stretch_count_ > 0 && top().first < oldest_; }
  /// The part of the newest stretch; -1: there is none.
  int body() const noexcept { return stretch_count_ == 0 ? -1 : top().body; }
  /// Forgets the newest stretch.
  void Drop() noexcept;

  /// Sets out to where the newest stretch begins.
  void SetOut(const Pose& X_WB) noexcept;
  /// A frame on the way: where the part is.
  void Advance(const Pose& X_WB) noexcept;
  void Stop() noexcept { state_ = State::kIdle; }

  State state() const noexcept { return state_; }
  /// Where the part is to be drawn to.
  const Pose& goal() const noexcept { return goal_; }

 private:
  struct Stretch {
    int body = -1;
    double radius = 0;
    std::uint64_t first = 0;  // into the poses
  };
  struct Poses {
    std::array<Pose, kMost> at;
  };
  Stretch& top() noexcept { return stretches_[(stretch_end_ - 1) % kMostStretches]; }
  const Stretch& top() const noexcept { return stretches_[(stretch_end_ - 1) % kMostStretches]; }
  Pose& pose(std::uint64_t number) noexcept { return poses_->at[number % kMost]; }
  /// The first pose of the newest stretch that is not forgotten.
  std::uint64_t first() const noexcept;
  void Push(const Pose& X_WB) noexcept;
  double Travel(const Pose& from, const Pose& to) const noexcept;

  std::unique_ptr<Poses> poses_;
  std::uint64_t end_ = 0;     // number of the pose that comes next
  std::uint64_t oldest_ = 0;  // all before are overwritten, whatever end_ is now
  std::array<Stretch, kMostStretches> stretches_{};
  std::uint64_t stretch_end_ = 0;
  std::size_t stretch_count_ = 0;
  State state_ = State::kIdle;
  Pose goal_;
  int waited_ = 0;  // frames since the goal's last step
};

}  // namespace tandem
