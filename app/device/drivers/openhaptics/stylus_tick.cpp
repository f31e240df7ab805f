// The work of the vendor's scheduler in each tick.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "app/device/drivers/openhaptics/stylus.h"
#include "engine/base/spatial.h"
#include "engine/realtime/clock.h"

namespace tandem::driver {
namespace {

// the place that an uncalibrated Touch reports, wherever its stylus is
constexpr std::array kStuckHdMm{0.0, -110.0, -35.0};
constexpr double kStuckWithinMm = 0.01;

bool IsStuck(const double (&transform)[16]) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (std::abs(transform[12 + i] - kStuckHdMm[i]) >= kStuckWithinMm) return false;
  }
  return true;
}

const char* WhatOf(unsigned code) {
  switch (code) {
    case 0x200:
      return "its motors are too warm: let it rest for a minute";
    case 0x201:
      return "a program asked for more force than it can give";
    case 0x202:
      return "its force changed too fast for it";
    case 0x203:
      return "its handle was too fast";
    default:
      return "it reports a force error";
  }
}

Quat OrientationOf(const double (&transform)[16]) {
  // columns of a rotation matrix that is slightly skewed
  const Vec3 x = Vec3(transform[0], transform[1], transform[2]).normalized();
  const Vec3 z = x.cross(Vec3(transform[4], transform[5], transform[6])).normalized();
  Mat3 R;
  R.col(0) = x;
  R.col(1) = z.cross(x);
  R.col(2) = z;
  return Quat(R).normalized();
}

}  // namespace

void Stylus::Tick() noexcept {
  if (lost_.load()) return;
  hd_.BeginFrame(device_);
  if (broken_.load()) {
    const double nothing[3] = {};
    hd_.SetDoublev(kHdForce, nothing);
    hd_.EndFrame(device_);
    return;
  }
  double transform[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  double v[3] = {};
  double w[3] = {};
  int mask = 0;
  unsigned code = 0;
  hd_.GetDoublev(kHdTransform, transform);
  hd_.GetIntegerv(kHdButtons, &mask);
  const bool has_speed =
      Get(kHdVelocity, v, has_velocity_, code) && Get(kHdAngularVelocity, w, has_turn_, code);
  if (ticks_++ % kCalibrationEvery == 0) calibration_ = CheckCalibration();
  if (IsStuck(transform)) {
    calibration_ = TANDEM_UNCALIBRATED;
    trouble_.Say(
        "the device does not know where its stylus is: put the stylus into the inkwell, and take "
        "it out");
  }
  WriteForce(code);
  hd_.EndFrame(device_);
  // outside the frame and without force, since a calibration makes the pose jump
  if (const unsigned style = std::exchange(update_, 0U); style != 0) hd_.UpdateCalibration(style);
  TakeFault(Worse(code, TakeErrors(hd_)));

  HandleSample sample;
  sample.time_ns = MonotonicNowNs();
  if (lost_.load()) {
    sample.result = TANDEM_UNPLUGGED;
    sample_.Write(sample);
    return;
  }
  sample.result = failed_ticks_ > 0 ? static_cast<std::int32_t>(TANDEM_FAILED) : calibration_;
  if (failed_ticks_ > 0 && --failed_ticks_ == 0 && calibration_ == TANDEM_OK) trouble_.Say("");
  const Quat q_VD = OrientationOf(transform);
  for (std::size_t i = 0; i < 3; ++i) {
    sample.p_VD[i] = kHdMm * transform[12 + i];
    sample.v_VD[i] = kHdMm * v[i];
    sample.w_VD[i] = w[i];
  }
  for (std::size_t i = 0; i < 4; ++i) sample.q_VD[i] = q_VD.coeffs()[static_cast<Eigen::Index>(i)];
  sample.valid = TANDEM_HAS_POSE;
  if (has_speed) sample.valid |= TANDEM_HAS_VELOCITY;
  const auto pressed = [mask](int button) {
    return button >= 0 && (static_cast<unsigned>(mask) >> static_cast<unsigned>(button) & 1U) != 0;
  };
  if (pressed(settings_.clutch)) sample.buttons |= TANDEM_BUTTON_CLUTCH;
  if (pressed(settings_.stop)) sample.buttons |= TANDEM_BUTTON_STOP;
  sample_.Write(sample);
}

bool Stylus::Get(unsigned what, double* values, Has& has, unsigned& code) noexcept {
  if (has == Has::kNot) return false;
  if (has == Has::kUnknown) code = Worse(code, TakeErrors(hd_));  // errors of earlier calls
  hd_.GetDoublev(what, values);
  if (has == Has::kYes) return true;
  const unsigned fault = TakeErrors(hd_);
  has = IsRefused(fault) ? Has::kNot : Has::kYes;
  if (has == Has::kYes) code = Worse(code, fault);
  return has == Has::kYes;
}

std::int32_t Stylus::CheckCalibration() noexcept {
  const unsigned state = hd_.CheckCalibration();
  if (state == kHdCalibrated) {
    if (calibration_ != TANDEM_OK) trouble_.Say("");
    return TANDEM_OK;
  }
  const auto style = static_cast<unsigned>(style_);
  if (state == kHdNeedsUpdate && (style & (kHdAuto | kHdInkwell)) != 0) {
    update_ = (style & kHdAuto) != 0 ? kHdAuto : kHdInkwell;
    trouble_.Say("the device calibrates itself: hold the stylus still");
    return TANDEM_UNCALIBRATED;
  }
  trouble_.Say((style & kHdInkwell) != 0
                   ? "the device is not calibrated: put the stylus into the inkwell"
                   : "the device is not calibrated: put its arms into the reset position, and give "
                     "calibrate=yes");
  return TANDEM_UNCALIBRATED;
}

void Stylus::WriteForce(unsigned& code) noexcept {
  double temperatures[6] = {};
  if (Get(kHdMotorTemperature, temperatures, has_temperature_, code)) {
    const double warmest = *std::ranges::max_element(temperatures);
    if (warmest > kWarm) share_ *= kShrink;
    if (warmest < kCool) share_ = std::min(1.0, kGrow * share_);
  }
  TandemDeviceForce force{};
  force.struct_size = sizeof force;
  host_->take(host_->context, &force);
  const std::int64_t now_ns = MonotonicNowNs();
  const bool stood = last_ns_ != 0 && now_ns - last_ns_ > kOldNs;
  last_ns_ = now_ns;
  const auto is_number = [](double x) {
    return std::isfinite(x);
  };
  const bool is_sound =
      std::ranges::all_of(force.force, is_number) && std::ranges::all_of(force.moment, is_number);
  const bool nothing =
      !is_sound || stood || stopped_.load() || failed_ticks_ > 0 || calibration_ != TANDEM_OK;
  // the host ramps too; this ramp holds even where the host does not
  ramp_ = nothing ? 0 : std::min(1.0, ramp_ + 1.0 / kRampTicks);
  if (nothing) force = {};
  double f[3];
  double t[3];
  for (int i = 0; i < 3; ++i) {
    f[i] = ramp_ * share_ * force.force[i];
    t[i] = ramp_ * share_ * force.moment[i] / kHdMilliNewtonMetre;
  }
  // in each frame, since the last force may stay at the motors
  hd_.SetDoublev(kHdForce, f);
  if (output_dof_ == 6) hd_.SetDoublev(kHdTorque, t);
}

void Stylus::TakeFault(unsigned code) noexcept {
  if (code == 0) return;
  if (IsForceError(code)) {
    failed_ticks_ = kFailedTicks;
    trouble_.Say(WhatOf(code));
  } else if (IsGone(code)) {
    trouble_.Say("the device does not answer: plug it in and switch it on");
    lost_.store(true);
  } else {
    char line[120];
    std::snprintf(line, sizeof line,
                  "the vendor's library reports a fault (%#x): end this program and start it again",
                  code);
    trouble_.Say(line);
    broken_.store(true);
  }
}

}  // namespace tandem::driver
