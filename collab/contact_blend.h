#pragma once

#include <algorithm>
#include <cmath>

namespace tandem {

/// How firmly a mirror stands where its peer says while we push it (paper §6.1, type-1). Our push
/// moves the real one only a delay later: a mirror that stands like a rock then gives back, late,
/// what was pressed in, and two that press one another bounce wherever the hand's period is about
/// four delays. So a mirror meets us firmly, and in 150 ms of contact gives way down to the
/// stiffness that the delay allows, B/te; parts stay out of one another, the mirror stands aside.
/// Its distance from the pose that was received is its lag, which is shown. Used by the haptic
/// thread alone.
class ContactBlend {
 public:
  static constexpr double kFirm = 2000.0;   // N/m
  static constexpr double kDrag = 10.0;     // B, N s/m
  static constexpr double kMostPull = 8.0;  // N of a mirror that cannot get to where it should be

  /// A frame of h seconds: whether the mirror was pushed in the last one, the delay that gains are
  /// made for (s), and the mirror's lag (m).
  void Next(bool pushed, double te_s, double lag, double h) noexcept {
    constexpr double kDecay = 0.05;        // s: done after three of these
    constexpr double kAfterContact = 0.1;  // s that a contact counts on
    constexpr double kThere = 1e-4;        // m
    since_push_ = pushed ? 0.0 : since_push_ + h;
    const bool touched = since_push_ < kAfterContact;
    const double soft = std::min(kFirm, kDrag / std::max(te_s, 1e-3));
    if (!yields_) {
      if (!pushed || soft >= kFirm) return;
      yields_ = true;
      stiffness_ = kFirm;
    }
    const double goal = touched ? soft : kFirm;
    lag_ = lag;
    stiffness_ += (goal - stiffness_) * (1.0 - std::exp(-h / kDecay));
    if (!touched && lag < kThere) yields_ = false;
  }

  bool yields() const noexcept { return yields_; }
  /// N/m, while it yields.
  double stiffness() const noexcept {
    return std::min(stiffness_, kMostPull / std::max(lag_, 1e-6));
  }
  /// Damping against the ground for a body of that mass (kg), N s/m: what the delay needs, and
  /// enough not to ring.
  double Drag(double mass) const noexcept {
    return std::max(kDrag, 1.4 * std::sqrt(stiffness() * mass));
  }

 private:
  bool yields_ = false;
  double stiffness_ = kFirm;
  double lag_ = 0;
  double since_push_ = 1e9;
};

}  // namespace tandem
