#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "engine/haptics/device.h"
#include "engine/realtime/triple_buffer.h"

namespace tandem {

/// A user's settings for reaching a large scene with a small device.
struct WorkspaceOrder {
  double scale = 1;  // initial metres in W per metre of the device; later set by Rescale()
  Quat q_WV = Quat::Identity();  // view: a device's axes are those of the user's picture
  bool clutch = false;  // held, here or at the device: the handle moves, and the part in hand stays
  std::uint32_t placements = 0;  // each puts the mapped, empty handle to p_WD
  Vec3 p_WD = Vec3::Zero();      // m
  double recentre = 0;           // share of its own way by which a hand is led back, 0–0.3
};

/// Changes to an order; a field without value stays.
struct WorkspaceChange {
  std::optional<Quat> q_WV{};
  std::optional<bool> clutch{};
  std::optional<double> recentre{};
  /// Place where the empty hand takes a part; ignored while it holds one.
  std::optional<Vec3> p_WD{};

  void ApplyTo(WorkspaceOrder& order) const {
    if (q_WV) order.q_WV = *q_WV;
    if (clutch) order.clutch = *clutch;
    if (recentre) order.recentre = *recentre;
    if (!p_WD) return;
    order.p_WD = *p_WD;
    ++order.placements;
  }
};

/// A device whose handle is mapped into the scene. It is scaled, turned by the view, and released
/// by a clutch, so that a hand continues from a comfortable place (indexing). A change of any of
/// these leaves the mapped handle where it is. With `recentre` the mapped handle goes a little
/// farther outwards with each bit of the hand's way. It does so the more, the farther the hand is
/// from the middle of the device. So the hand comes back to the middle without noticing. A hand at
/// rest is left alone. Before Start() the clutch counts as held. A handle that moves while scenes
/// load and partners are awaited moves nothing. A part taken at that time does not jump after it.
///
/// A newton on the part is a newton in the hand. So a spring of the scene is felt `scale` times as
/// stiff, and the gains that the device bears are smaller by that factor. The simulation follows
/// the scaled handle: scale enters the limit on travel (paper §5), and a hand beyond that feels the
/// virtual coupling.
class Workspace : public Device {
 public:
  static constexpr double kLeastScale = 0.01;
  static constexpr double kMostScale = 100;
  static constexpr double kMostRecentre = 0.3;
  /// Frames of the force's ramp, after the clutch is released.
  static constexpr int kRampFrames = 100;

  /// `device` must outlive this object. The handle is first mapped onto itself.
  explicit Workspace(Device& device, const WorkspaceOrder& order = {}) noexcept;

  /// Returns the buffer of the newest order, which one other thread writes.
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
  /// Continues from where the mapped handle is.
  void Index(const Anchor& handle) noexcept;

  Device* device_;
  DeviceCapabilities can_;
  TripleBuffer<WorkspaceOrder> orders_;
  WorkspaceOrder order_;
  double scale_;
  bool holds_ = false;
  bool placed_ = false;
  bool started_ = false;
  int led_frames_ = kRampFrames;  // frames since the clutch was released
  Vec3 middle_ = Vec3::Zero();    // middle of the device's workspace
  double radius_ = 0.1;           // radius of the workspace, m
  // at the last start of indexing: the device's handle, and the mapped handle
  Pose X_VD0_;
  Pose X_WD0_;
  Anchor mapped_;
  Vec3 last_p_VD_ = Vec3::Zero();
};

}  // namespace tandem
