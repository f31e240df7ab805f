#pragma once

#include <algorithm>

namespace tandem {

/// What a pair's candidates cost beside their tests (paper §5 counts tests alone): how many exact
/// looks every frame owes, and how many a metre of travel makes due.
///
/// Owed whatever the travel: points that push or bear on something, for which no other place is
/// known where they do not. Due by travel: points that have left what was known of them, and points
/// that have come within the force layer. Of these the rate is that of the last frames, all their
/// looks over all their travel, and it is believed up to twice what they came to: how many come due
/// at a speed far above theirs is not known before, and at rest nothing is.
///
/// With more travel a point is due more often, but at most once a frame, so looks grow no faster
/// than travel: a limit taken from their rate comes to rest and does not swing
/// (docs/decisions/0015-frame.md).
/// All in looks; what is less is a share of one.
class LookLoad {
 public:
  /// A frame's looks, after `travel` m. Infinite travel: where bodies were before is not known.
  void Count(double owed, double due, double travel) noexcept {
    owed_ = owed;
    if (!(travel < kFar)) return;
    due_ += kNew * (due - due_);
    travel_ += kNew * (travel - travel_);
  }
  /// Exact looks in every frame.
  double owed() const noexcept { return owed_; }
  /// Exact looks for a metre of travel; `least` is the travel, m, that a frame may always make:
  /// what comes due at rest is spread over no less.
  double PerMetre(double least) const noexcept { return due_ / std::max(travel_, least); }
  double most() const noexcept { return kBelieved * due_; }

 private:
  static constexpr double kNew = 1.0 / 16;  // the share of a frame in what is known of the last
  static constexpr double kBelieved = 1.5;
  static constexpr double kFar = 1e3;  // m

  double owed_ = 0;
  double due_ = 0;     // means over the last frames
  double travel_ = 0;  // m
};

}  // namespace tandem
