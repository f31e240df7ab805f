#include "collab/retrace.h"

#include <algorithm>
#include <cmath>

#include "collab/energy_gate.h"
#include "engine/world/world.h"

namespace tandem {

namespace {

// whether a line was free is known some frames late: that many moments earlier it is certain
constexpr std::int64_t kCertain = 5;
constexpr int kMostMoments = 64;  // gone through in a frame, where the body stood

/// The newest moment at which a straight line led to the other, from `nearest` m at the most; -1:
/// none is kept.
std::int64_t LastFree(const PoseHistory& history, PeerId peer, double nearest, double angle) {
  std::int64_t run = 0;
  for (std::int64_t moment = history.end() - 1; moment >= history.begin(); --moment) {
    const bool free = history.WasFree(peer, moment);
    run = free ? run + 1 : 0;
    if (run <= kCertain) continue;
    const Pose& ours = history.Ours(moment);
    const Pose& theirs = *history.Of(peer, moment);
    if ((theirs.p - ours.p).norm() <= nearest && ours.q.angularDistance(theirs.q) <= angle) {
      return moment;
    }
  }
  return -1;
}

}  // namespace

bool Retrace::Start(const PoseHistory& history, PeerId towards, const Pose& X_WB,
                    double radius) noexcept {
  state_ = State::kIdle;
  together_ = LastFree(history, towards, kTogether, kTogetherAngle);
  if (together_ < 0) together_ = LastFree(history, towards, 1e9, 1e9);
  if (together_ < 0) return false;
  state_ = State::kUnderWay;
  towards_ = towards;
  radius_ = radius;
  back_ = true;
  moment_ = history.end() - 1;
  goal_ = X_WB;
  stuck_frames_ = 0;
  return true;
}

const Pose* Retrace::Next(const PoseHistory& history) const noexcept {
  if (moment_ < history.begin()) return nullptr;
  return back_ ? &history.Ours(moment_) : history.Of(towards_, moment_);
}

double Retrace::Travel(const Pose& from, const Pose& to) const noexcept {
  return TravelOf(to.p - from.p, from.q.angularDistance(to.q), radius_);
}

void Retrace::Advance(const PoseHistory& history, const Pose& X_WB) noexcept {
  if (state_ != State::kUnderWay) return;
  const Pose* last = history.Of(towards_, history.end() - 1);
  if (last == nullptr || ++stuck_frames_ > kStuckFrames) {
    state_ = State::kStuck;
    return;
  }
  // the body comes along, it is not torn
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
      goal_ = Between(goal_, *next, left / way);
      stuck_frames_ = 0;
      return;
    }
    goal_ = *next;
    left -= way;
    if (way > 0) stuck_frames_ = 0;
    if (back_ && moment_ > together_) {
      --moment_;
    } else if (back_) {
      back_ = false;  // over to the other, of that moment
    } else if (moment_ + 1 < history.end()) {
      ++moment_;
    } else {
      if (Travel(X_WB, *last) < kThere) state_ = State::kArrived;
      return;
    }
  }
}

CouplingGains RetraceGains(const Inertia& inertia) noexcept {
  constexpr double kStiffness = 800.0;  // N/m
  const double damping = 1.4 * std::sqrt(kStiffness * inertia.mass);
  const Mat3 rotation = 0.5 * inertia.I_B.trace() / inertia.mass * Mat3::Identity();
  return {kStiffness, damping, kStiffness * rotation, damping * rotation};
}

}  // namespace tandem
