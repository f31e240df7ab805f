#include "engine/haptics/path_backtracker.h"

#include <algorithm>

#include "engine/world/world.h"

namespace tandem {

PathBacktracker::PathBacktracker() : poses_(std::make_unique<Poses>()) {}

std::uint64_t PathBacktracker::first() const noexcept {
  return std::max(top().first, oldest_);
}

double PathBacktracker::Travel(const Pose& from, const Pose& to) const noexcept {
  return TravelOf(to.p - from.p, from.q.angularDistance(to.q), top().radius);
}

void PathBacktracker::Push(const Pose& X_WB) noexcept {
  pose(end_++) = X_WB;
  if (end_ > kMost) oldest_ = std::max(oldest_, end_ - kMost);
}

void PathBacktracker::Begin(int body, double radius, const Pose& X_WB) noexcept {
  state_ = State::kIdle;
  stretches_[stretch_end_++ % kMostStretches] = {.body = body, .radius = radius, .first = end_};
  stretch_count_ = std::min(stretch_count_ + 1, kMostStretches);
  Push(X_WB);
}

void PathBacktracker::Note(const Pose& X_WB) noexcept {
  if (stretch_count_ == 0 || state_ == State::kUnderWay) return;
  if (Travel(pose(end_ - 1), X_WB) >= kStep) Push(X_WB);
}

void PathBacktracker::Drop() noexcept {
  if (stretch_count_ == 0) return;
  state_ = State::kIdle;
  end_ = top().first;
  --stretch_end_;
  --stretch_count_;
  // the earlier stretches are wholly forgotten if the dropped way was cut, or began there
  if (end_ <= oldest_) {
    stretch_count_ = 0;
    end_ = oldest_;
  }
}

void PathBacktracker::SetOut(const Pose& X_WB) noexcept {
  state_ = State::kNotHere;
  if (stretch_count_ == 0 || Travel(pose(end_ - 1), X_WB) > kAway) return;
  state_ = State::kUnderWay;
  goal_ = X_WB;
  waited_ = 0;
}

void PathBacktracker::Advance(const Pose& X_WB) noexcept {
  if (state_ != State::kUnderWay) return;
  // waits that many frames at least, because the rest of the way may be shorter than a step
  if (++waited_ > kStuckFrames) state_ = State::kStuck;
  double left = kSpeed * kFrame;
  while (left > 0 && Travel(goal_, X_WB) < kLead) {
    const Pose& next = pose(end_ - 1);
    const double travel = Travel(goal_, next);
    if (travel > left) {
      const double share = left / travel;
      goal_ = {goal_.q.slerp(share, next.q), goal_.p + share * (next.p - goal_.p)};
      waited_ = 0;
      return;
    }
    left -= travel;
    goal_ = next;
    if (end_ - 1 == first()) break;
    waited_ = 0;
    --end_;
  }
  const bool at_beginning = end_ - 1 == first() && Travel(goal_, pose(end_ - 1)) < 1e-9;
  if (!at_beginning) return;
  // a part that friction or weight keeps from settling arrives after a while too
  const double left_m = Travel(goal_, X_WB);
  if (left_m < kSettled || (waited_ > kSettleFrames && left_m < kThere)) {
    state_ = cut() ? State::kCut : State::kArrived;
  }
}

}  // namespace tandem
