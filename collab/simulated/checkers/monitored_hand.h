#pragma once

#include <cstddef>
#include <utility>

#include "collab/simulated/checkers/session_checker.h"
#include "engine/haptics/scripted_device.h"

namespace tandem {

/// Tells when a moving body has come to rest: slow for a tenth of a second.
class RestDetector {
 public:
  void See(const Twist& V) noexcept {
    frames_ = V.v.norm() < kSpeed && V.w.norm() < kTurn ? frames_ + 1 : 0;
  }
  bool is_still() const noexcept { return frames_ >= kFrames; }

 private:
  static constexpr double kSpeed = 2e-3;  // m/s
  static constexpr double kTurn = 0.02;   // rad/s
  static constexpr int kFrames = 100;

  int frames_ = 0;
};

/// A scripted hand whose device shows the checker the wrenches that it gets.
class MonitoredHand : public Device {
 public:
  MonitoredHand(HandScript script, const Pose& X_WB0, SessionChecker& checker, std::size_t peer)
      : hand_(std::move(script), X_WB0), checker_(&checker), peer_(peer) {}

  void Start() noexcept override { hand_.Start(); }
  Anchor Read() noexcept override { return hand_.Read(); }
  void Render(const Wrench& F_D_W) noexcept override {
    checker_->RenderedForces(peer_, F_D_W);
    hand_.Render(F_D_W);
    stillness_.See(hand_.Read().V_WA);
  }
  /// Returns whether the script is over and the hand has come to rest.
  bool at_home() const {
    return hand_.time() >= hand_.script().duration() && stillness_.is_still();
  }

 private:
  ScriptedDevice hand_;
  RestDetector stillness_;
  SessionChecker* checker_;
  std::size_t peer_;
};

}  // namespace tandem
