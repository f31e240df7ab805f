#pragma once

#include <algorithm>

#include "engine/world/step_inputs.h"

namespace tandem {

/// nCapacity from frame to frame (paper §5 takes it as known): what was measured before the loop,
/// corrected by what the last frames took. Tests and looks cost less where they stand together, as
/// they do in close fit, and more where a frame meets what no other has; what was measured lay here
/// and there. The capacity it gives is an input of the frame, so runs can still be repeated.
///
/// Frames with little to do tell what a frame costs besides tests and looks; those with much tell
/// what these cost in place of what was measured. Used by one thread; reads no clock.
class CapacityFollower {
 public:
  /// `tests` point tests were measured to fit into `budget_s` of a frame, a look at `look_price` of
  /// them.
  CapacityFollower(double tests, double look_price, double budget_s) noexcept
      : tests_(tests), look_price_(look_price), budget_s_(budget_s) {}

  /// For the next frame.
  double tests() const noexcept { return tests_ * (1.0 - beside_s_ / budget_s_) / PriceShare(); }
  /// After a frame: what it did, and the processor time that it took.
  void Count(const StepReport& report, double took_s) noexcept {
    const double tested = report.tests.tests();
    const double priced_s = budget_s_ * (tested + look_price_ * report.look_work) / tests_;
    if (priced_s < kLittle * budget_s_) {
      const double beside = std::clamp(took_s - PriceShare() * priced_s, 0.0, kBeside * budget_s_);
      beside_s_ += kNew * (beside - beside_s_);
      return;
    }
    // what the machine does beside, once in a while, is no work
    const double took = std::clamp(took_s - beside_s_, kLeast * priced_s, kMost * priced_s);
    took_s_ += kNew * (took - took_s_);
    priced_s_ += kNew * (priced_s - priced_s_);
  }

 private:
  static constexpr double kNew = 1.0 / 64;  // the share of a frame in what is known of the last
  static constexpr double kLittle = 0.1;    // of the budget
  static constexpr double kFew = 0.05;      // that the price was right, to begin with
  static constexpr double kBeside = 0.5;    // and at most, besides tests and looks
  /// Times what was measured that tests and looks may turn out to cost.
  static constexpr double kLeast = 0.25;
  static constexpr double kMost = 2.0;

  /// 1 until frames with much to do have been seen.
  double PriceShare() const noexcept {
    const double few = kFew * budget_s_;
    return (took_s_ + few) / (priced_s_ + few);
  }

  double tests_;
  double look_price_;
  double budget_s_;
  double beside_s_ = 0;  // means over the last frames
  double took_s_ = 0;
  double priced_s_ = 0;  // by what was measured before the loop
};

}  // namespace tandem
