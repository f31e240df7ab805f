#include "engine/haptics/workspace.h"

#include <cmath>

namespace tandem {
namespace {

WorkspaceOrder Sound(WorkspaceOrder order) {
  if (!order.p_WD.allFinite()) order.p_WD.setZero();
  if (!std::isfinite(order.recentre)) order.recentre = 0;
  order.recentre = std::clamp(order.recentre, 0.0, Workspace::kMostRecentre);
  const double norm = order.q_WV.norm();
  order.q_WV = std::isfinite(norm) && norm > 0.5 ? order.q_WV.normalized() : Quat::Identity();
  return order;
}

}  // namespace

double Workspace::SoundScale(double scale) noexcept {
  return std::isfinite(scale) ? std::clamp(scale, kLeastScale, kMostScale) : 1;
}

Workspace::Workspace(Device& device, const WorkspaceOrder& order) noexcept
    : device_(&device),
      can_(device.capabilities()),
      order_(Sound(order)),
      scale_(SoundScale(order.scale)) {
  order_.scale = scale_;
  orders_.back() = order_;
  orders_.Publish();
  if (can_.workspace.empty()) return;
  middle_ = can_.workspace.centre();
  radius_ = std::max(0.01, 0.5 * can_.workspace.size().minCoeff());
}

DeviceCapabilities Workspace::capabilities() const noexcept {
  DeviceCapabilities can = can_;
  can.stiffness /= scale_;
  can.damping /= scale_;
  return can;
}

void Workspace::Index(const Anchor& handle) noexcept {
  X_VD0_ = handle.X_WA;
  X_WD0_ = mapped_.X_WA;
  last_p_VD_ = handle.X_WA.p;
}

void Workspace::Take(const WorkspaceOrder& newest) noexcept {
  order_ = Sound(newest);
}

Anchor Workspace::Read() noexcept {
  const Anchor handle = device_->Read();  // in the device's own axes
  if (!handle.X_WA.p.allFinite() || !handle.X_WA.q.coeffs().allFinite()) return handle;
  WorkspaceOrder wanted = Sound(orders_.Read());
  wanted.scale = scale_;
  wanted.clutch = wanted.clutch || device_->clutch_button() || !started_;
  if (!placed_) {
    placed_ = true;
    mapped_ = handle;
    Index(handle);
  }
  if (wanted.placements != order_.placements && !holds_) {
    mapped_.X_WA.p = wanted.p_WD;
    Index(handle);
  }
  const bool changed = wanted.scale != order_.scale || wanted.clutch != order_.clutch ||
                       wanted.q_WV.coeffs() != order_.q_WV.coeffs();
  if (changed || order_.clutch) Index(handle);
  Take(wanted);
  if (order_.clutch) {
    mapped_.V_WA = {};
    return mapped_;
  }

  const Quat& q_WV = order_.q_WV;
  if (order_.recentre > 0) {
    // a little outwards with each bit of its way, so that the hand must come in by as much
    const double way = (handle.X_WA.p - last_p_VD_).norm();
    const Vec3 out = (handle.X_WA.p - middle_) / radius_;
    const double share = std::min(1.0, out.norm());
    const Vec3 outwards = out.norm() > 1e-6 ? Vec3(out.normalized()) : Vec3(Vec3::Zero());
    X_WD0_.p += order_.scale * order_.recentre * share * way * (q_WV * outwards);
  }
  last_p_VD_ = handle.X_WA.p;
  const Quat turned = q_WV * handle.X_WA.q * X_VD0_.q.conjugate() * q_WV.conjugate();
  mapped_.X_WA.q = (turned * X_WD0_.q).normalized();
  mapped_.X_WA.p = X_WD0_.p + order_.scale * (q_WV * Vec3(handle.X_WA.p - X_VD0_.p));
  mapped_.V_WA.w = q_WV * handle.V_WA.w;
  mapped_.V_WA.v = order_.scale * (q_WV * handle.V_WA.v);
  return mapped_;
}

void Workspace::Render(const Wrench& F_D_W) noexcept {
  if (order_.clutch) {
    led_frames_ = 0;
    device_->Render({});
    return;
  }
  // a hand that releases the clutch in contact does not get all of the force at once
  led_frames_ = std::min(led_frames_ + 1, kRampFrames);
  const double share = static_cast<double>(led_frames_) / kRampFrames;
  const Quat q_VW = order_.q_WV.conjugate();
  device_->Render({share * (q_VW * F_D_W.tau), share * (q_VW * F_D_W.f)});
}

}  // namespace tandem
