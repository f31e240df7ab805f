#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

#include "app/study/study.h"
#include "engine/base/spatial.h"

namespace tandem {

/// The measures of a trial. NaN: the value is unknown or does not apply.
struct TrialMeasures {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  double success = kNone;       // 1 or 0 by the task's criteria
  double completion_s = kNone;  // time from the hand's start until the goal is reached and kept to
                                // the end
  double duration_s = kNone;
  double peak_force_N = kNone;
  double mean_force_N = kNone;
  double collisions = kNone;
  double contact_s = kNone;
  double path_mm = kNone;
  double moved_mm = kNone;
  double divergence_mm = kNone;
  double delay_ms = kNone;
  double missed_share = kNone;
};

/// The description of a measure, with its name in logs and results.
struct TrialMeasure {
  std::string_view name;
  std::string_view unit;
  std::string_view about;
  double TrialMeasures::*value;
};

std::span<const TrialMeasure> AllTrialMeasures();

/// The participant's hand in a frame.
struct TrialFrame {
  double t_s = 0;    // time since the hand's start
  Pose X_WB;         // pose of the body in hand
  double force = 0;  // N, at the hand
  bool contact = false;
};

/// Measures a trial frame by frame, for peers in virtual time and real peers alike.
class TrialMeter {
 public:
  /// Returns whether the body at that pose has left what is fixed. Null: nothing is fixed.
  using IsOut = std::function<bool(const Pose& X_WB)>;

  TrialMeter(const StudySuccess& success, const Pose& X_WB0, IsOut is_out);

  /// Takes a frame. Ignores frames after the trial's end.
  void See(const TrialFrame& frame);
  /// Takes the distance between the two instances of the body in a frame, m.
  void SeeApart(double metres);
  /// Returns whether the goal was kept long enough for the trial to be over (StudySuccess::hold_s).
  bool ended() const noexcept { return ended_; }
  TrialMeasures Finish() const;

 private:
  bool Reached(const Pose& X_WB) const;

  StudySuccess success_;
  Pose X_WB0_;
  IsOut is_out_;
  std::int64_t frames_ = 0;
  double first_s_ = 0;
  double last_s_ = 0;
  Pose last_;
  double next_look_s_ = 0;
  std::optional<double> reached_s_;  // time since which the goal has been reached without a break
  bool ended_ = false;
  double force_sum_ = 0;
  double peak_force_ = 0;
  double contact_s_ = 0;
  double free_since_s_ = -1;
  bool touching_ = false;
  int collisions_ = 0;
  double path_ = 0;
  double moved_ = 0;
  std::optional<double> apart_;
};

}  // namespace tandem
