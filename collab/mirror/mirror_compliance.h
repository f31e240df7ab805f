#pragma once

#include <algorithm>
#include <cmath>

namespace tandem {

/// Decides how stiff a mirror is while this peer pushes it (paper §6.1, type-1). The push moves the
/// real body only a delay later. A mirror as stiff as a rock returns the push late, and two that
/// press one another bounce where the hand's period is about four delays. So a mirror meets a push
/// firmly, and within 150 ms of contact softens to the stiffness B/te that the delay allows: the
/// mirror gives way, and parts do not penetrate one another. The mirror's distance from the
/// received pose is its lag, which is shown. Used by the haptic thread alone.
class MirrorCompliance {
 public:
  static constexpr double kFirm = 2000.0;   // N/m
  static constexpr double kDrag = 10.0;     // B, N s/m
  static constexpr double kMostPull = 8.0;  // N; pull of a mirror that cannot reach its pose

  /// Advances a frame of `h` seconds. `pushed`: the last frame pushed the mirror; `te_s`: the delay
  /// that gains are made for; `lag`: the mirror's lag, m.
  void Next(bool pushed, double te_s, double lag, double h) noexcept {
    constexpr double kDecay = 0.05;        // s; the stiffness has settled after three of these
    constexpr double kAfterContact = 0.1;  // s; a contact counts for this long
    constexpr double kThere = 1e-4;        // m; a lag below it is none
    since_push_ = pushed ? 0.0 : since_push_ + h;
    const bool touched = since_push_ < kAfterContact;
    const double soft = std::min(kFirm, kDrag / std::max(te_s, 1e-3));
    if (!compliant_) {
      if (!pushed || soft >= kFirm) return;
      compliant_ = true;
      stiffness_ = kFirm;
    }
    const double goal = touched ? soft : kFirm;
    lag_ = lag;
    stiffness_ += (goal - stiffness_) * (1.0 - std::exp(-h / kDecay));
    if (!touched && lag < kThere) compliant_ = false;
  }

  bool compliant() const noexcept { return compliant_; }
  /// Stiffness while the mirror yields, N/m.
  double stiffness() const noexcept {
    return std::min(stiffness_, kMostPull / std::max(lag_, 1e-6));
  }
  /// Returns the damping against the ground for a body of `mass` kg, N s/m: the law's B, or more
  /// where the body would ring.
  double Drag(double mass) const noexcept {
    return std::max(kDrag, 1.4 * std::sqrt(stiffness() * mass));
  }

 private:
  bool compliant_ = false;
  double stiffness_ = kFirm;
  double lag_ = 0;
  double since_push_ = 1e9;
};

}  // namespace tandem
