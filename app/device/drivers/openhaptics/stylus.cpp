#include "app/device/drivers/openhaptics/stylus.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <vector>

#include "engine/base/spatial.h"
#include "engine/realtime/clock.h"

namespace tandem::driver {
namespace {

constexpr double kMm = 1e-3;
constexpr std::int64_t kLastTicksNs = 5'000'000;
constexpr double kMilliNewtonMetre = 1e-3;
constexpr double kSoftestArm = 500;  // N/m that the smallest of them renders without shaking
// where an uncalibrated Touch says that its stylus is, wherever that is
constexpr std::array kStuckMm{0.0, -110.0, -35.0};
constexpr double kStuckWithinMm = 0.01;

bool IsGone(unsigned code) {
  return code >= kHdDeviceFault && code <= kHdTimer && code != kHdAlreadyInitiated;
}
bool Passes(unsigned code) {
  return code >= kHdWarmMotors && code <= kHdForceError;
}

const char* WhatOf(unsigned code) {
  switch (code) {
    case 0x200:
      return "its motors are too warm: let it rest for a minute";
    case 0x201:
      return "it was asked for more force than it can give";
    case 0x202:
      return "its force changed too fast for it";
    case 0x203:
      return "its handle was too fast";
    default:
      return "it reports a force error";
  }
}

Quat OrientationOf(const double (&transform)[16]) {
  // columns of a matrix that is slightly skewed
  const Vec3 x = Vec3(transform[0], transform[1], transform[2]).normalized();
  const Vec3 z = x.cross(Vec3(transform[4], transform[5], transform[6])).normalized();
  Mat3 R;
  R.col(0) = x;
  R.col(1) = z.cross(x);
  R.col(2) = z;
  return Quat(R).normalized();
}

}  // namespace

Stylus::Stylus(const Hd& hd, const TandemDeviceHost& host, const Settings& settings)
    : hd_(hd), host_(&host), settings_(settings) {}

Stylus::~Stylus() {
  over_.store(true);
  if (keeper_.joinable()) keeper_.join();
  stopped_.store(true);
  // for the scheduler to write zero: what it wrote last may stay at the motors
  if (is_scheduled_) MachineClock().SleepUntil(MonotonicNowNs() + kLastTicksNs);
  EndScheduler();
}

std::string Stylus::Init() {
  std::vector<std::string> names{settings_.device};
  if (settings_.device.empty()) names = {"Default Device", "Default PHANToM"};
  std::string why;
  for (const std::string& name : names) {
    device_ = hd_.InitDevice(name.c_str());
    const unsigned code = hd_.GetError().code;
    if (code == 0 && device_ != kHdNoDevice) {
      hd_.MakeCurrentDevice(device_);
      return {};
    }
    device_ = kHdNoDevice;
    const char* said = hd_.GetErrorString(code);
    why = "'" + name + "' does not open (" + (said != nullptr ? said : "no reason given") + ")";
    if (code == kHdNoLicence) return why + ": the vendor's licence is missing or has ended";
    if (code == kHdAlreadyInitiated) return why + ": end the other program that has it";
  }
  return why + ": plug it in, switch it on, and set it up by the vendor's Touch_Setup";
}

std::string Stylus::Open() {
  if (const std::string fault = Init(); !fault.empty()) return fault;
  hd_.GetIntegerv(kHdOutputDof, &output_dof_);
  hd_.GetIntegerv(kHdCalibrationStyle, &style_);
  can_.struct_size = sizeof can_;
  can_.freedoms_in = 6;
  can_.freedoms_out = output_dof_ == 6 ? 6 : 3;
  can_.asks = 1;
  can_.stiffness = kSoftestArm;
  hd_.GetDoublev(kHdMaxForce, &can_.peak_force);
  hd_.GetDoublev(kHdMaxContinuousForce, &can_.continuous_force);
  if (output_dof_ == 6) can_.peak_moment = can_.continuous_moment = 0.188;  // Premium 1.5, 6 DOF
  double workspace[6] = {};
  hd_.GetDoublev(kHdUsableWorkspace, workspace);
  for (int i = 0; i < 3; ++i) {
    can_.workspace_min[i] = kMm * workspace[i];
    can_.workspace_max[i] = kMm * workspace[3 + i];
  }
  const auto style = static_cast<unsigned>(style_);
  if (settings_.calibrates && (style & kHdEncoderReset) != 0) {
    hd_.UpdateCalibration(kHdEncoderReset);  // before the scheduler starts
  }
  if (const unsigned code = hd_.GetError().code; code != 0) {
    return "the device does not say what it can: switch it off and on";
  }
  return {};
}

std::string Stylus::BeginScheduler() {
  scheduled_ = hd_.ScheduleAsynchronous(
      [](void* of) {
        static_cast<Stylus*>(of)->Tick();
        return kHdContinue;
      },
      this, kHdHighestPriority);
  is_scheduled_ = true;
  hd_.Enable(kHdForceOutput);
  hd_.SetSchedulerRate(1000);
  if (hd_.GetError().code != 0) {
    host_->say(host_->context, "openhaptics: the device keeps a rate of its own, not 1000 Hz");
  }
  hd_.StartScheduler();
  if (const unsigned code = hd_.GetError().code; code != 0) {
    const char* said = hd_.GetErrorString(code);
    return std::string("the vendor's scheduler does not start: ") +
           (said != nullptr ? said : "no reason given");
  }
  return {};
}

void Stylus::EndScheduler() noexcept {
  if (is_scheduled_) {
    hd_.StopScheduler();
    hd_.Unschedule(scheduled_);
    is_scheduled_ = false;
  }
  if (device_ == kHdNoDevice) return;
  hd_.DisableDevice(device_);
  device_ = kHdNoDevice;
}

std::string Stylus::Start() {
  const std::string fault = BeginScheduler();
  if (fault.empty())
    keeper_ = std::thread([this] {
      Keep();
    });
  return fault;
}

void Stylus::Tick() noexcept {
  if (lost_.load()) return;
  if (broken_.load()) {
    const double nothing[3] = {};
    hd_.BeginFrame(device_);
    hd_.SetDoublev(kHdForce, nothing);
    hd_.EndFrame(device_);
    return;
  }
  hd_.BeginFrame(device_);
  double transform[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  double v[3] = {};
  double w[3] = {};
  int mask = 0;
  hd_.GetDoublev(kHdTransform, transform);
  hd_.GetDoublev(kHdVelocity, v);
  hd_.GetDoublev(kHdAngularVelocity, w);
  hd_.GetIntegerv(kHdButtons, &mask);
  if (ticks_++ % kCalibrationEvery == 0) calibration_ = CheckCalibration();
  bool is_stuck = true;
  for (std::size_t i = 0; i < 3; ++i) {
    is_stuck = is_stuck && std::abs(transform[12 + i] - kStuckMm[i]) < kStuckWithinMm;
  }
  if (is_stuck) {
    calibration_ = TANDEM_UNCALIBRATED;
    trouble_.Say(
        "the device does not know where its stylus is: put it into the inkwell, and take it out");
  }
  WriteForce();
  hd_.EndFrame(device_);
  TakeError();

  Sample sample;
  sample.time_ns = MonotonicNowNs();
  sample.result = failed_ticks_ > 0 ? static_cast<std::int32_t>(TANDEM_FAILED) : calibration_;
  if (failed_ticks_ > 0 && --failed_ticks_ == 0 && calibration_ == TANDEM_OK) trouble_.Say("");
  const Quat q_VD = OrientationOf(transform);
  for (std::size_t i = 0; i < 3; ++i) {
    sample.p_VD[i] = kMm * transform[12 + i];
    sample.v_VD[i] = kMm * v[i];
    sample.w_VD[i] = w[i];
  }
  for (std::size_t i = 0; i < 4; ++i) sample.q_VD[i] = q_VD.coeffs()[static_cast<Eigen::Index>(i)];
  const auto pressed = [mask](int button) {
    return button >= 0 && (static_cast<unsigned>(mask) >> static_cast<unsigned>(button) & 1U) != 0;
  };
  if (pressed(settings_.clutch)) sample.buttons |= TANDEM_BUTTON_CLUTCH;
  if (pressed(settings_.stop)) sample.buttons |= TANDEM_BUTTON_STOP;
  if (!lost_.load() && !broken_.load()) sample_.Write(sample);
}

std::int32_t Stylus::CheckCalibration() noexcept {
  const unsigned state = hd_.CheckCalibration();
  if (state == kHdCalibrated) {
    if (calibration_ != TANDEM_OK) trouble_.Say("");
    return TANDEM_OK;
  }
  const auto style = static_cast<unsigned>(style_);
  if (state == kHdNeedsUpdate && (style & (kHdAuto | kHdInkwell)) != 0) {
    hd_.UpdateCalibration((style & kHdAuto) != 0 ? kHdAuto : kHdInkwell);
    return calibration_;
  }
  trouble_.Say((style & kHdInkwell) != 0
                   ? "the device is not calibrated: put the stylus into the inkwell"
                   : "the device is not calibrated: put its arms into the reset position, and give "
                     "calibrate=yes");
  return TANDEM_UNCALIBRATED;
}

void Stylus::WriteForce() noexcept {
  double temperatures[6] = {};
  hd_.GetDoublev(kHdMotorTemperature, temperatures);
  const double warmest = *std::ranges::max_element(temperatures);
  if (warmest > kWarm) share_ *= kShrink;
  if (warmest < kCool) share_ = std::min(1.0, kGrow * share_);
  TandemDeviceForce force{};
  force.struct_size = sizeof force;
  host_->take(host_->context, &force);
  const auto is_number = [](double x) {
    return std::isfinite(x);
  };
  const bool is_sound =
      std::ranges::all_of(force.force, is_number) && std::ranges::all_of(force.moment, is_number);
  if (!is_sound || stopped_.load() || failed_ticks_ > 0 || calibration_ != TANDEM_OK) force = {};
  double f[3];
  double t[3];
  for (int i = 0; i < 3; ++i) {
    f[i] = share_ * force.force[i];
    t[i] = share_ * force.moment[i] / kMilliNewtonMetre;
  }
  // in each frame, for the last one may stay at the motors
  hd_.SetDoublev(kHdForce, f);
  if (output_dof_ == 6) hd_.SetDoublev(kHdTorque, t);
}

void Stylus::TakeError() noexcept {
  const unsigned code = hd_.GetError().code;
  if (code == 0) return;
  if (Passes(code)) {
    failed_ticks_ = kFailedTicks;
    trouble_.Say(WhatOf(code));
  } else if (IsGone(code)) {
    trouble_.Say("the device does not answer: plug it in and switch it on");
    lost_.store(true);
  } else {
    trouble_.Say("the vendor's library is in trouble: end this program and begin anew");
    broken_.store(true);
  }
}

void Stylus::Keep() {
  int waited_ms = kReopenMs;  // it may be back at once
  while (!over_.load()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(kLookMs));
    if (!lost_.load()) continue;
    EndScheduler();
    waited_ms += kLookMs;
    if (waited_ms < kReopenMs) continue;
    waited_ms = 0;
    if (!Init().empty()) continue;
    calibration_ = TANDEM_OK;
    ticks_ = failed_ticks_ = 0;
    trouble_.Say("");
    lost_.store(false);
    if (!BeginScheduler().empty()) lost_.store(true);
  }
}

std::int32_t Stylus::Read(TandemDeviceState& state) noexcept {
  if (broken_.load()) return TANDEM_BROKEN;
  if (lost_.load()) return TANDEM_UNPLUGGED;
  Sample sample;
  if (!sample_.Read(sample)) return TANDEM_REPEATED;
  if (MonotonicNowNs() - sample.time_ns > kOldNs) return TANDEM_FAILED;
  if (sample.result < 0) return sample.result;
  state.buttons = sample.buttons;
  if (sample.time_ns == read_ns_) return TANDEM_REPEATED;
  read_ns_ = sample.time_ns;
  state.valid = TANDEM_HAS_POSE | TANDEM_HAS_VELOCITY;
  state.time_ns = sample.time_ns;
  std::ranges::copy(sample.p_VD, state.position);
  std::ranges::copy(sample.q_VD, state.orientation);
  std::ranges::copy(sample.v_VD, state.velocity);
  std::ranges::copy(sample.w_VD, state.angular_velocity);
  return TANDEM_OK;
}

std::string Stylus::Trouble() const {
  const std::string line = trouble_.line();
  if (!line.empty()) return line;
  Sample sample;
  if (sample_.Read(sample) && MonotonicNowNs() - sample.time_ns > kOldNs) {
    return "the vendor's scheduler stands still";
  }
  return {};
}

}  // namespace tandem::driver
