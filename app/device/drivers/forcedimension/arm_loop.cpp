// The arm's own thread.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "app/device/drivers/forcedimension/arm.h"
#include "engine/base/spatial.h"
#include "engine/realtime/clock.h"

namespace tandem::driver {
namespace {

constexpr double kSlow = 0.1;                 // m/s; below it the device may release its brakes
constexpr std::int64_t kLostNs = 20'000'000;  // time of failing calls after which the device is
                                              // gone

/// Converts the vendor's axes (to the person, right, up) to V's (right, up, to the person).
std::array<double, 3> InV(const double (&of)[3]) {
  return {of[1], of[2], of[0]};
}

const char* WhyNoForce(int cause) {
  switch (cause) {
    case kDhdByButton:
      return "the force is switched off: press the force button on the device";
    case kDhdBySpeed:
      return "the handle moved too fast, so the device braked: hold it still";
    case kDhdByWatchdog:
      return "the device received no force for 20 ms and switched its force off";
    case kDhdByUsb:
      return "the device switched its force off because USB failed";
    case kDhdByDeadMan:
      return "the device feels no hand: take hold of the handle";
    default:
      return "the device has switched its force off";
  }
}

}  // namespace

void Arm::Turn(std::int64_t now_ns) noexcept {
  if (lost_) Reopen(now_ns);
  if (lost_) return;
  // before the force: a device that was switched off and on may have lost its reference
  if (now_ns - status_ns_ >= kStatusNs) {
    status_ns_ = now_ns;
    status_ = ReadStatus();
    if (lost_) return;
  }
  HandleSample sample;
  const bool is_well = Measure(sample) && WriteForce();
  if (is_well) {
    failing_since_ns_ = 0;
  } else if (TakeFault(now_ns)) {
    return;
  }
  sample.time_ns = MonotonicNowNs();
  sample.result = is_well ? status_ : static_cast<std::int32_t>(TANDEM_FAILED);
  sample_.Write(sample);
}

bool Arm::TakeFault(std::int64_t now_ns) noexcept {
  const int fault = dhd_.ErrorGetLast();
  if (failing_since_ns_ == 0) failing_since_ns_ = now_ns;
  const bool is_gone = fault == kDhdCom || fault == kDhdNoDevice || fault == kDhdTimeout;
  if (is_gone && now_ns - failing_since_ns_ > kLostNs) {
    Lose("the device does not answer: plug it in and switch it on");
    return true;
  }
  const char* message = dhd_.ErrorGetLastStr();
  char line[160];
  std::snprintf(line, sizeof line, "a call to the device failed (%s): switch it off and on",
                message != nullptr ? message : "no reason given");
  trouble_.Say(line);
  return false;
}

bool Arm::Measure(HandleSample& sample) noexcept {
  double p[3] = {0, 0, 0};
  double R[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  // 1 and 2 are no errors: no newer sample, or a motor at its limit
  if (dhd_.GetPositionAndOrientationFrame(&p[0], &p[1], &p[2], R, id_) < 0) return false;
  sample.p_VD = InV(p);
  Mat3 R_VD = Mat3::Identity();
  if (has_wrist_) {
    constexpr int kAxis[3] = {1, 2, 0};  // index of V's axes among the vendor's
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) R_VD(i, j) = R[kAxis[i]][kAxis[j]];
    }
  }
  const Quat q_VD = Quat(R_VD).normalized();
  for (std::size_t i = 0; i < 4; ++i) sample.q_VD[i] = q_VD.coeffs()[static_cast<Eigen::Index>(i)];
  sample.valid = TANDEM_HAS_POSE;
  double v[3] = {0, 0, 0};
  double w[3] = {0, 0, 0};
  if (dhd_.GetLinearVelocity(&v[0], &v[1], &v[2], id_) >= 0 &&
      (!has_wrist_ || dhd_.GetAngularVelocityRad(&w[0], &w[1], &w[2], id_) >= 0)) {
    sample.v_VD = InV(v);
    sample.w_VD = InV(w);
    speed_ = std::hypot(v[0], v[1], v[2]);
    sample.valid |= TANDEM_HAS_VELOCITY;
  }
  const unsigned mask = dhd_.GetButtonMask(id_);
  const auto pressed = [mask](int button) {
    return button >= 0 && (mask >> static_cast<unsigned>(button) & 1U) != 0;
  };
  sample.buttons = (pressed(settings_.clutch) ? std::uint32_t{TANDEM_BUTTON_CLUTCH} : 0U) |
                   (pressed(settings_.stop) ? std::uint32_t{TANDEM_BUTTON_STOP} : 0U);
  return true;
}

bool Arm::WriteForce() noexcept {
  TandemDeviceForce force{};
  force.struct_size = sizeof force;
  host_->take(host_->context, &force);
  const bool is_sound = std::ranges::all_of(force.force,
                                            [](double x) {
                                              return std::isfinite(x);
                                            }) &&
                        std::ranges::all_of(force.moment, [](double x) {
                          return std::isfinite(x);
                        });
  if (!is_sound || stopped_.load() || status_ != TANDEM_OK) force = {};
  if (!drives_wrist_) std::ranges::fill(force.moment, 0.0);
  // V's axes (right, up, to the person) as the vendor's (to the person, right, up)
  const double* f = force.force;
  const double* t = force.moment;
  // 2, a motor at its limit, is no error
  return dhd_.SetForceAndTorque(f[2], f[0], f[1], t[2], t[0], t[1], id_) >= 0;
}

std::int32_t Arm::ReadStatus() noexcept {
  int status[17] = {};
  if (dhd_.GetStatus(status, id_) < 0) {
    if (status_ == TANDEM_FAILED) {
      trouble_.Say("the device does not report its state: switch it off and on");
    }
    return status_;
  }
  if (status[kDhdConnected] == 0) {
    Lose("the device is no longer connected: plug it in");
    return TANDEM_UNPLUGGED;
  }
  if (status[kDhdReset] == 0) {
    trouble_.Say(
        "the device has not found its reference: move the handle through its whole range, or give "
        "calibrate=yes to let the arm move itself");
    return TANDEM_UNCALIBRATED;
  }
  if (status[kDhdForce] == 0) {
    const int cause = status[kDhdForceOffCause];
    trouble_.Say(WhyNoForce(cause));
    // not where a person switched the force off, or the brake holds a fast handle; the host gives
    // no force until `resume`
    const bool is_fast = cause == kDhdBySpeed && speed_ > kSlow;
    if (cause != kDhdByButton && cause != kDhdByDeadMan && !is_fast) {
      dhd_.SetBrakes(0, id_);
      dhd_.EnableForce(1, id_);
    }
    return TANDEM_FAILED;
  }
  trouble_.Say("");
  return TANDEM_OK;
}

void Arm::Lose(const char* why) noexcept {
  trouble_.Say(why);
  lost_ = true;
  failing_since_ns_ = 0;
  reopen_ns_ = MonotonicNowNs() + kReopenNs;
  dhd_.Close(id_);
  id_ = -1;
  HandleSample sample;
  sample.time_ns = MonotonicNowNs();
  sample.result = TANDEM_UNPLUGGED;
  sample_.Write(sample);
}

void Arm::Reopen(std::int64_t now_ns) noexcept {
  HandleSample sample;
  sample.time_ns = MonotonicNowNs();
  sample.result = TANDEM_UNPLUGGED;
  sample_.Write(sample);
  if (now_ns < reopen_ns_) return;
  reopen_ns_ = now_ns + kReopenNs;
  const int id = dhd_.OpenID(static_cast<char>(settings_.index));
  if (id < 0) return;
  id_ = static_cast<char>(id);
  if (!Prepare().empty()) {
    dhd_.Close(id_);
    id_ = -1;
    return;
  }
  lost_ = false;
}

}  // namespace tandem::driver
