#include "engine/haptics/device_memory.h"

namespace tandem {

std::array<double, 7> AsNumbers(const Pose& pose) noexcept {
  const auto& q = pose.q.coeffs();
  return {q[0], q[1], q[2], q[3], pose.p[0], pose.p[1], pose.p[2]};
}

Pose AsPose(const std::array<double, 7>& n) noexcept {
  return {Quat(n[3], n[0], n[1], n[2]), Vec3(n[4], n[5], n[6])};
}

std::array<double, 16> AsNumbers(const DeviceCapabilities& of) noexcept {
  // the bounds are stored by their least and greatest corner
  const Vec3& a = of.workspace.min;
  const Vec3& b = of.workspace.max;
  const double freedoms = of.freedoms_in + 10.0 * of.freedoms_out + (of.asks_us ? 100.0 : 0.0) +
                          (of.in_scene ? 1000.0 : 0.0);
  return {freedoms,
          of.peak.force,
          of.peak.moment,
          of.continuous.force,
          of.continuous.moment,
          a.x(),
          a.y(),
          a.z(),
          b.x(),
          b.y(),
          b.z(),
          of.rate_hz,
          of.stiffness,
          of.damping,
          of.rotation_stiffness,
          of.rotation_damping};
}

DeviceCapabilities AsCapabilities(const std::array<double, 16>& n) noexcept {
  const auto freedoms = static_cast<int>(n[0]);
  DeviceCapabilities of;
  of.in_scene = freedoms >= 1000;
  of.asks_us = freedoms % 1000 >= 100;
  of.freedoms_in = freedoms % 10;
  of.freedoms_out = freedoms % 100 / 10;
  of.peak = {n[1], n[2]};
  of.continuous = {n[3], n[4]};
  of.workspace.min = Vec3(n[5], n[6], n[7]);
  of.workspace.max = Vec3(n[8], n[9], n[10]);
  of.rate_hz = n[11];
  of.stiffness = n[12];
  of.damping = n[13];
  of.rotation_stiffness = n[14];
  of.rotation_damping = n[15];
  return of;
}

}  // namespace tandem
