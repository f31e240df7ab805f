#pragma once

#include <algorithm>

#include "engine/world/step_inputs.h"

namespace tandem {

/// Estimates nCapacity from frame to frame (paper §5 takes it as known): the figure measured ahead
/// of the loop, corrected by the times of the last frames. Tests and exact queries cost less where
/// they stand together, as in a close fit, and more where a frame meets what no other has. The
/// measured figure comes from scattered ones. The capacity is an input of the frame, so runs can be
/// repeated.
///
/// Frames with little to do show what a frame costs besides tests and exact queries. Frames with
/// much to do show what tests and exact queries really cost. Used by one thread; reads no clock.
class CapacityFollower {
 public:
  /// `tests`: point tests measured to fit into `budget_s` of a frame. `query_price`: cost of a
  /// query in such tests.
  CapacityFollower(double tests, double query_price, double budget_s) noexcept
      : tests_(tests), query_price_(query_price), budget_s_(budget_s) {}

  /// Returns the capacity for the next frame, in point tests.
  double tests() const noexcept { return tests_ * (1.0 - beside_s_ / budget_s_) / PriceShare(); }
  /// Takes account of a frame: what it did, and the processor time that it took.
  void Count(const StepReport& report, double took_s) noexcept {
    const double tested = report.tests.tests();
    const double priced_s = budget_s_ * (tested + query_price_ * report.query_cost) / tests_;
    if (priced_s < kLittle * budget_s_) {
      const double beside = std::clamp(took_s - PriceShare() * priced_s, 0.0, kBeside * budget_s_);
      beside_s_ += kNew * (beside - beside_s_);
      return;
    }
    // outliers are other activity of the machine, not work
    const double took = std::clamp(took_s - beside_s_, kLeast * priced_s, kMost * priced_s);
    took_s_ += kNew * (took - took_s_);
    priced_s_ += kNew * (priced_s - priced_s_);
  }

 private:
  static constexpr double kNew = 1.0 / 64;  // share of the latest frame in the means
  static constexpr double kLittle = 0.1;    // share of the budget
  /// Share of the budget, as weight of the measured price at the start.
  static constexpr double kFew = 0.05;
  static constexpr double kBeside =
      0.5;  // greatest share of the budget besides tests and exact queries
  /// Bounds of the real cost of tests and exact queries, as a multiple of the measured cost.
  static constexpr double kLeast = 0.25;
  static constexpr double kMost = 2.0;

  /// Returns the real cost of tests and exact queries as a multiple of the measured cost: 1 until
  /// frames with much to do have come.
  double PriceShare() const noexcept {
    const double few = kFew * budget_s_;
    return (took_s_ + few) / (priced_s_ + few);
  }

  double tests_;
  double query_price_;
  double budget_s_;
  double beside_s_ = 0;  // mean over the last frames, as the next two
  double took_s_ = 0;
  double priced_s_ = 0;  // by the measured price
};

}  // namespace tandem
