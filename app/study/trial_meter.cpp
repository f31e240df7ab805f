#include "app/study/trial_meter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace tandem {

namespace {

constexpr double kLookS = 0.01;      // time between two tests of the goal
constexpr double kApartS = 0.1;      // contacts less far apart in time count as one collision
constexpr double kLeastStep = 1e-4;  // m; length of a path's steps, so that noise adds nothing

constexpr std::array kMeasures{
    TrialMeasure{"success", "0 or 1", "1 if all criteria of the task are met",
                 &TrialMeasures::success},
    TrialMeasure{"completion_s", "s",
                 "time from the hand's start until the goal (out, or moved_mm) is reached and then "
                 "kept to the trial's end, checked every 10 ms; empty if it is not reached",
                 &TrialMeasures::completion_s},
    TrialMeasure{"duration_s", "s", "length of the trial, from the hand's start",
                 &TrialMeasures::duration_s},
    TrialMeasure{"peak_force_N", "N", "largest force at the participant's hand",
                 &TrialMeasures::peak_force_N},
    TrialMeasure{"mean_force_N", "N", "mean of that force over all frames",
                 &TrialMeasures::mean_force_N},
    TrialMeasure{"collisions", "1",
                 "number of times that contact began, after at least 0.1 s without contact",
                 &TrialMeasures::collisions},
    TrialMeasure{"contact_s", "s", "time in contact", &TrialMeasures::contact_s},
    TrialMeasure{"path_mm", "mm",
                 "length of the path of the body's centre of mass, in steps of 0.1 mm",
                 &TrialMeasures::path_mm},
    TrialMeasure{"moved_mm", "mm",
                 "distance of the body's centre of mass from its first place, at the end",
                 &TrialMeasures::moved_mm},
    TrialMeasure{"divergence_mm", "mm",
                 "largest distance between the two instances of the body at equal times; with a "
                 "partner at another site, from received poses, with clocks compared by echoes",
                 &TrialMeasures::divergence_mm},
    TrialMeasure{"delay_ms", "ms", "measured one-way delay: half the mean loop age",
                 &TrialMeasures::delay_ms},
    TrialMeasure{
        "missed_share", "0 to 1",
        "share of frames that the participant's peer missed: a measure of the trial's quality",
        &TrialMeasures::missed_share}};
static_assert(sizeof(TrialMeasures) == kMeasures.size() * sizeof(double));  // none is missing

}  // namespace

std::span<const TrialMeasure> AllTrialMeasures() {
  return kMeasures;
}

TrialMeter::TrialMeter(const StudySuccess& success, const Pose& X_WB0, IsOut is_out)
    : success_(success), X_WB0_(X_WB0), is_out_(std::move(is_out)) {}

bool TrialMeter::Reached(const Pose& X_WB) const {
  if (success_.out) return is_out_ != nullptr && is_out_(X_WB);
  return success_.moved_mm && 1e3 * (X_WB.p - X_WB0_.p).norm() >= *success_.moved_mm;
}

void TrialMeter::See(const TrialFrame& frame) {
  if (ended_) return;
  if (frames_ == 0) {
    first_s_ = last_s_ = next_look_s_ = frame.t_s;
    last_ = frame.X_WB;
  }
  const double elapsed = frame.t_s - last_s_;
  ++frames_;
  force_sum_ += frame.force;
  peak_force_ = std::max(peak_force_, frame.force);
  if (frame.contact) {
    const bool fresh = free_since_s_ < 0 || frame.t_s - free_since_s_ >= kApartS;
    if (!touching_ && fresh) ++collisions_;
    contact_s_ += elapsed;
  } else if (touching_) {
    free_since_s_ = frame.t_s;
  }
  touching_ = frame.contact;
  const double step = (frame.X_WB.p - last_.p).norm();
  if (step >= kLeastStep) {
    path_ += step;
    last_.p = frame.X_WB.p;
  }
  moved_ = (frame.X_WB.p - X_WB0_.p).norm();
  last_s_ = frame.t_s;
  if (frame.t_s + 1e-9 < next_look_s_) return;
  next_look_s_ = frame.t_s + kLookS;
  if (!Reached(frame.X_WB)) {
    reached_s_.reset();
  } else if (!reached_s_) {
    reached_s_ = frame.t_s - first_s_;
  } else {
    ended_ = frame.t_s - first_s_ - *reached_s_ >= success_.hold_s - 1e-9;
  }
}

void TrialMeter::SeeApart(double metres) {
  apart_ = std::max(apart_.value_or(0), metres);
}

TrialMeasures TrialMeter::Finish() const {
  TrialMeasures measures;
  if (frames_ == 0) return measures;
  measures.completion_s = reached_s_.value_or(TrialMeasures::kNone);
  measures.duration_s = last_s_ - first_s_;
  measures.peak_force_N = peak_force_;
  measures.mean_force_N = force_sum_ / static_cast<double>(frames_);
  measures.collisions = collisions_;
  measures.contact_s = contact_s_;
  measures.path_mm = 1e3 * path_;
  measures.moved_mm = 1e3 * moved_;
  if (apart_) measures.divergence_mm = 1e3 * *apart_;
  const bool done = !success_.has_goal() || reached_s_;
  const bool in_time = !success_.time_s || measures.completion_s <= *success_.time_s;
  const bool gentle = !success_.peak_force_N || peak_force_ <= *success_.peak_force_N;
  const bool clear = !success_.collisions || collisions_ <= *success_.collisions;
  measures.success = done && in_time && gentle && clear ? 1 : 0;
  return measures;
}

}  // namespace tandem
