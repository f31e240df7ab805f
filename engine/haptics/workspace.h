#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "engine/haptics/device.h"
#include "engine/realtime/triple_buffer.h"

namespace tandem {

/// How a user wants a small device to reach a large scene.
struct WorkspaceOrder {
  double scale = 1;              // metres in W a metre of the device; at first: Rescale()
  Quat q_WV = Quat::Identity();  // the view: a device's axes are those of the user's picture
  bool clutch = false;  // held, here or at the device: the handle moves, what it holds stays
  std::uint32_t placements = 0;  // each puts the mapped handle to p_WD, which nobody holds yet
  Vec3 p_WD = Vec3::Zero();      // m
  double recentre = 0;           // share of its own way by which a hand is led back, 0–0.3
};

/// What of an order is to be another; nothing: stays.
struct WorkspaceChange {
  std::optional<Quat> q_WV{};
  std::optional<bool> clutch{};
  std::optional<double> recentre{};
  std::optional<Vec3> p_WD{};  // where the empty hand is to take a part; while it has one: nothing

  void ApplyTo(WorkspaceOrder& order) const {
    if (q_WV) order.q_WV = *q_WV;
    if (clutch) order.clutch = *clutch;
    if (recentre) order.recentre = *recentre;
    if (!p_WD) return;
    order.p_WD = *p_WD;
    ++order.placements;
  }
};

/// A device whose handle is mapped into the scene: scaled, turned by the view, and let go of by a
/// clutch, so that a hand goes on from where it is comfortable (indexing). A change of any of them
/// leaves the mapped handle where it is. With `recentre` the mapped handle goes a little farther
/// outwards with each bit of the hand's way, the more so the farther that is from the middle of the
/// device: the hand comes back to the middle without noticing. A hand at rest is left alone.
/// Before Start() it is as with the clutch: a handle that somebody moves while scenes load and
/// partners are waited for moves nothing, and what is taken then does not jump after it.
///
/// A newton on the part is a newton in the hand. So a spring of the scene is felt `scale` times as
/// stiff, and the gains that the device bears are that much smaller. The scaled handle is what the
/// simulation follows: scale enters the limit on travel (paper §5), and a hand beyond that feels
/// the virtual coupling.
class Workspace : public Device {
 public:
  static constexpr double kLeastScale = 0.01;
  static constexpr double kMostScale = 100;
  static constexpr double kMostRecentre = 0.3;
  static constexpr int kRampFrames = 100;  // of the force, once the clutch is let go of

  /// `device` outlives this. The handle is first mapped onto itself.
  explicit Workspace(Device& device, const WorkspaceOrder& order = {}) noexcept;

  /// The newest order; written by one other thread.
  TripleBuffer<WorkspaceOrder>& orders() noexcept { return orders_; }

  void Start() noexcept override {
    started_ = true;
    device_->Start();
  }
  Anchor Read() noexcept override;
  void Render(const Wrench& F_D_W) noexcept override;
  void Stop() noexcept override { device_->Stop(); }
  void Resume() noexcept override { device_->Resume(); }
  void Rescale(double scale) noexcept override { scale_ = SoundScale(scale); }
  void Holding(bool holds) noexcept override { holds_ = holds; }
  DeviceCapabilities capabilities() const noexcept override;
  bool failed() const noexcept override { return device_->failed(); }
  bool stop_button() const noexcept override { return device_->stop_button(); }
  bool clutch_button() const noexcept override { return device_->clutch_button(); }
  DeviceSafety safety() const noexcept override { return device_->safety(); }

 private:
  void Take(const WorkspaceOrder& order) noexcept;
  static double SoundScale(double scale) noexcept;
  /// Goes on from where the mapped handle is.
  void Index(const Anchor& handle) noexcept;

  Device* device_;
  DeviceCapabilities can_;
  TripleBuffer<WorkspaceOrder> orders_;
  WorkspaceOrder order_;
  double scale_;
  bool holds_ = false;
  bool placed_ = false;
  bool started_ = false;
  int led_frames_ = kRampFrames;  // since the clutch was let go of
  Vec3 middle_ = Vec3::Zero();    // of the device's workspace
  double radius_ = 0.1;           // m, of it
  // where indexing last began: the device's handle, and the mapped one
  Pose X_VD0_;
  Pose X_WD0_;
  Anchor mapped_;
  Vec3 last_p_VD_ = Vec3::Zero();
};

}  // namespace tandem
