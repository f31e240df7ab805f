#include "collab/separation/return_path.h"

#include <algorithm>
#include <cmath>

#include "collab/coupling/energy_gate.h"
#include "engine/world/world.h"

namespace tandem {

namespace {

// a line is known to be free some frames late: that many moments earlier it is certain
constexpr std::int64_t kCertain = 5;

}  // namespace

void ReturnPath::Start(const PoseHistory& history, PeerId towards, double radius) noexcept {
  state_ = State::kSearching;
  towards_ = towards;
  radius_ = radius;
  sought_ = history.end() - 1;
  free_run_ = 0;
  together_ = -1;
}

void ReturnPath::Search(const PoseHistory& history) noexcept {
  if (state_ != State::kSearching) return;
  for (int moments = 0; moments < kMostMoments; ++moments, --sought_) {
    if (sought_ < history.begin()) {
      // the two were never near, but a straight line joined them once
      state_ = together_ >= history.begin() ? State::kFound : State::kNoWay;
      return;
    }
    free_run_ = history.WasFree(towards_, sought_) ? free_run_ + 1 : 0;
    if (free_run_ <= kCertain) continue;
    if (together_ < 0) together_ = sought_;
    const Pose& ours = history.Ours(sought_);
    const Pose& theirs = *history.PoseOf(towards_, sought_);
    if ((theirs.p - ours.p).norm() <= kTogether &&
        ours.q.angularDistance(theirs.q) <= kTogetherAngle) {
      together_ = sought_;
      state_ = State::kFound;
      return;
    }
  }
}

void ReturnPath::SetOut(const PoseHistory& history, const Pose& X_WB) noexcept {
  if (state_ != State::kFound) return;
  state_ = State::kUnderWay;
  back_ = true;
  moment_ = history.end() - 1;
  goal_ = X_WB;
  frames_ = 0;
  stuck_frames_ = 0;
}

const Pose* ReturnPath::Next(const PoseHistory& history) const noexcept {
  if (moment_ < history.begin()) return nullptr;
  return back_ ? &history.Ours(moment_) : history.PoseOf(towards_, moment_);
}

double ReturnPath::Travel(const Pose& from, const Pose& to) const noexcept {
  return TravelOf(to.p - from.p, from.q.angularDistance(to.q), radius_);
}

void ReturnPath::Advance(const PoseHistory& history, const Pose& X_WB) noexcept {
  if (state_ != State::kUnderWay) return;
  const Pose* last = history.PoseOf(towards_, history.end() - 1);
  if (last == nullptr || ++stuck_frames_ > kStuckFrames || ++frames_ > kMostFrames) {
    state_ = State::kStuck;
    return;
  }
  // the goal waits for the body
  if (Travel(X_WB, goal_) > kLead) return;
  double left = kSpeed * kFrame;
  for (int moments = 0; left > 0 && moments < kMostMoments; ++moments) {
    const Pose* next = Next(history);
    if (next == nullptr) {
      state_ = State::kStuck;
      return;
    }
    const double way = Travel(goal_, *next);
    if (way > left) {
      goal_ = Interpolate(goal_, *next, left / way);
      stuck_frames_ = 0;
      return;
    }
    goal_ = *next;
    left -= way;
    if (way > 0) stuck_frames_ = 0;
    if (back_ && moment_ > together_) {
      --moment_;
    } else if (back_) {
      back_ = false;  // over to the other's path, at the same moment
    } else if (moment_ + 1 < history.end()) {
      ++moment_;
    } else {
      if (Travel(X_WB, *last) < kThere) state_ = State::kArrived;
      return;
    }
  }
}

CouplingGains ReturnPathGains(const Inertia& inertia) noexcept {
  constexpr double kStiffness = 800.0;  // N/m
  const double damping = 1.4 * std::sqrt(kStiffness * inertia.mass);
  const Mat3 rotation = 0.5 * inertia.I_B.trace() / inertia.mass * Mat3::Identity();
  return {kStiffness, damping, kStiffness * rotation, damping * rotation};
}

}  // namespace tandem
