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

/// What is measured of a trial. NaN: it is not known, or there is nothing of the kind.
struct TrialMeasures {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  double success = kNone;       // 1 or 0, by the task's criteria
  double completion_s = kNone;  // from the hand's start until the goal is reached for good
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

/// A measure by its name, as logs and results give it.
struct TrialMeasure {
  std::string_view name;
  std::string_view unit;
  std::string_view about;
  double TrialMeasures::*value;
};

std::span<const TrialMeasure> AllTrialMeasures();

/// A frame of the participant's hand.
struct TrialFrame {
  double t_s = 0;    // from the hand's start
  Pose X_WB;         // of the body in hand
  double force = 0;  // N, at the hand
  bool contact = false;
};

/// Measures a trial frame by frame, the same for peers in virtual time and for real ones.
class TrialMeter {
 public:
  /// Whether the body at that pose has left what is fixed; null: nothing is fixed.
  using IsOut = std::function<bool(const Pose& X_WB)>;

  TrialMeter(const StudySuccess& success, const Pose& X_WB0, IsOut is_out);

  /// Frames after the trial's end count no more.
  void See(const TrialFrame& frame);
  /// The distance between the two instances of the body in a frame, m.
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
  std::optional<double> reached_s_;  // since when the goal is reached without a break
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
