#include "app/device/drivers/forcedimension/arm.h"

#include <algorithm>
#include <cmath>

#include "engine/base/spatial.h"
#include "engine/realtime/clock.h"

namespace tandem::driver {
namespace {

constexpr int kArmPriority = 41;  // above the device's loop: the motors are served first
constexpr int kMostStops = 50;    // tries to end the force
constexpr std::int64_t kBetweenStopsNs = 2'000'000;
constexpr std::int64_t kLostNs = 20'000'000;  // of calls that fail: the device is gone

struct Model {
  int type;
  double force;      // N
  double moment;     // N m, of an active wrist
  double stiffness;  // N/m that its loop bears; 0: not known
};
// published figures; what the list does not have gets the least of them
constexpr std::array kModels{Model{33, 12, 0, 5000}, Model{34, 12, 0, 5000}, Model{36, 12, 0, 5000},
                             Model{35, 12, 0, 5000}, Model{37, 12, 0, 5000}, Model{60, 8, 0, 0},
                             Model{63, 20, 0, 0},    Model{104, 12, 0.2, 0}, Model{105, 12, 0.2, 0},
                             Model{108, 12, 0.2, 0}, Model{109, 12, 0.2, 0}};
constexpr Model kUnknownModel{0, 8, 0.2, 0};

Model ModelOf(int type) {
  const auto found = std::ranges::find(kModels, type, &Model::type);
  return found == kModels.end() ? kUnknownModel : *found;
}

/// The vendor's axes (to the person, right, up) as V's (right, up, to the person).
std::array<double, 3> InV(const double (&of)[3]) {
  return {of[1], of[2], of[0]};
}

const char* WhyNoForce(int cause) {
  switch (cause) {
    case 1:
      return "its force is switched off: press the force button at the device";
    case 2:
      return "the handle was too fast for the device, which braked: hold it still";
    case 3:
      return "the device got no force for 20 ms and switched it off";
    case 5:
      return "the device switched its force off, for USB failed";
    case 6:
      return "the device feels no hand: take hold of the handle";
    default:
      return "the device has switched its force off";
  }
}

}  // namespace

Arm::Arm(const Dhd& dhd, const TandemDeviceHost& host, const Settings& settings)
    : dhd_(dhd), host_(&host), settings_(settings) {}

Arm::~Arm() {
  thread_.reset();
  Close();
}

std::string Arm::Open() {
  const auto index = static_cast<char>(settings_.index);
  id_ = static_cast<char>(settings_.calibrates ? dhd_.drdOpenID(index) : dhd_.OpenID(index));
  if (id_ < 0) {
    const int fault = dhd_.ErrorGetLast();
    const char* said = dhd_.ErrorGetLastStr();
    std::string why = "the device does not open: ";
    why += said != nullptr ? said : "no reason given";
    if (fault == kDhdNoDriver) {
      why += ": its USB driver has no right: see 'tandem devices'";
    } else if (fault == kDhdBusy) {
      why += ": end the other program that has it";
    } else {
      why += ": plug it in and switch it on";
    }
    return why;
  }
  if (settings_.calibrates) {
    if (!dhd_.drdIsInitialized(id_) && dhd_.drdAutoInit(id_) < 0) {
      return "the device did not find its reference: move the handle to the middle, and try again";
    }
    dhd_.drdStop(true, id_);
  }
  const Model model = ModelOf(dhd_.GetSystemType(id_));
  has_wrist_ = dhd_.HasWrist(id_);
  drives_wrist_ = dhd_.HasActiveWrist(id_);
  most_force_ = model.force;
  most_moment_ = drives_wrist_ ? model.moment : 0;
  return Prepare();
}

std::string Arm::Prepare() {
  const bool is_guarded = dhd_.EnableExpertMode() >= 0 && dhd_.SetWatchdog(kWatchdog, id_) >= 0;
  if (!is_guarded) {
    return "the device's watchdog cannot be set, without which a crash may leave a force";
  }
  if (dhd_.SetMaxForce(most_force_, id_) < 0 ||
      (drives_wrist_ && dhd_.SetMaxTorque(most_moment_, id_) < 0)) {
    return "the device's limit of force cannot be set";
  }
  if (dhd_.SetBrakes(0, id_) < 0 || dhd_.EnableForce(1, id_) < 0 ||
      dhd_.SetForceAndTorque(0, 0, 0, 0, 0, 0, id_) < 0) {
    const char* said = dhd_.ErrorGetLastStr();
    return std::string("the device's motors cannot be switched on: ") +
           (said != nullptr ? said : "no reason given");
  }
  prepared_ = true;
  // acts while forces are sent; a device that has none goes without
  dhd_.SetGravityCompensation(1, id_);
  return {};
}

void Arm::Capabilities(TandemDeviceCapabilities& can) const {
  const Model model = ModelOf(dhd_.GetSystemType(id_));
  can.freedoms_in = has_wrist_ ? 6 : 3;
  can.freedoms_out = drives_wrist_ ? 6 : 3;
  can.asks = 1;
  can.moves_by_itself = settings_.calibrates ? 1 : 0;
  can.peak_force = can.continuous_force = most_force_;
  can.peak_moment = can.continuous_moment = most_moment_;
  can.stiffness = model.stiffness;
}

void Arm::Start() {
  thread_ = std::make_unique<PeriodicThread>(
      PeriodicThread::Options{
          .period_ns = kPeriodNs, .priority = kArmPriority, .name = "forcedimension"},
      [this](std::int64_t, std::int64_t now_ns) {
        Turn(now_ns);
        return true;
      });
}

void Arm::Turn(std::int64_t now_ns) noexcept {
  if (lost_) {
    Reopen(now_ns);
    return;
  }
  Sample sample;
  const bool is_measured = Measure(sample);
  if (is_measured) {
    WriteForce();
    failing_since_ns_ = 0;
  } else {
    const int fault = dhd_.ErrorGetLast();
    if (failing_since_ns_ == 0) failing_since_ns_ = now_ns;
    const bool is_gone = fault == kDhdCom || fault == kDhdNoDevice || fault == kDhdTimeout;
    if (is_gone && now_ns - failing_since_ns_ > kLostNs) {
      Lose("the device does not answer: plug it in and switch it on");
      return;
    }
  }
  if (now_ns - status_ns_ >= kStatusNs) {
    status_ns_ = now_ns;
    status_ = LookAtStatus();
    if (lost_) return;
  }
  sample.time_ns = MonotonicNowNs();
  sample.result = is_measured ? status_ : static_cast<std::int32_t>(TANDEM_FAILED);
  if (!is_measured) trouble_.Say("a call to the device failed");
  sample_.Write(sample);
}

bool Arm::Measure(Sample& sample) noexcept {
  double p[3] = {0, 0, 0};
  double R[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  // 1 and 2 are no errors: nothing newer than a moment ago, a motor at its limit
  if (dhd_.GetPositionAndOrientationFrame(&p[0], &p[1], &p[2], R, id_) < 0) return false;
  sample.p_VD = InV(p);
  Mat3 R_VD = Mat3::Identity();
  if (has_wrist_) {
    constexpr int kAxis[3] = {1, 2, 0};  // V's axes among the vendor's
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

void Arm::WriteForce() noexcept {
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
  // V's (right, up, to the person) as the vendor's (to the person, right, up)
  const double* f = force.force;
  const double* t = force.moment;
  dhd_.SetForceAndTorque(f[2], f[0], f[1], t[2], t[0], t[1], id_);
}

std::int32_t Arm::LookAtStatus() noexcept {
  int status[17] = {};
  if (dhd_.GetStatus(status, id_) < 0) return status_;
  if (status[kDhdConnected] == 0) {
    Lose("the device is not connected any more: plug it in");
    return TANDEM_UNPLUGGED;
  }
  if (status[kDhdReset] == 0) {
    trouble_.Say(
        "the device has not found its reference: move the handle through its whole range, or give "
        "calibrate=yes, by which the arm moves itself");
    return TANDEM_UNCALIBRATED;
  }
  if (status[kDhdForce] == 0) {
    trouble_.Say(WhyNoForce(status[kDhdForceOffCause]));
    // the host gives nothing until a person resumes
    dhd_.EnableForce(1, id_);
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
  Sample sample;
  sample.time_ns = MonotonicNowNs();
  sample.result = TANDEM_UNPLUGGED;
  sample_.Write(sample);
}

void Arm::Reopen(std::int64_t now_ns) noexcept {
  Sample sample;
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
  status_ns_ = 0;
  status_ = TANDEM_OK;
}

std::int32_t Arm::Read(TandemDeviceState& state) noexcept {
  Sample sample;
  if (!sample_.Read(sample)) return TANDEM_REPEATED;
  if (MonotonicNowNs() - sample.time_ns > kOldNs) return TANDEM_FAILED;
  if (sample.result < 0) return sample.result;
  if (sample.time_ns == read_ns_) {
    state.buttons = sample.buttons;
    return TANDEM_REPEATED;
  }
  read_ns_ = sample.time_ns;
  state.valid = sample.valid;
  state.time_ns = sample.time_ns;
  state.buttons = sample.buttons;
  std::ranges::copy(sample.p_VD, state.position);
  std::ranges::copy(sample.q_VD, state.orientation);
  std::ranges::copy(sample.v_VD, state.velocity);
  std::ranges::copy(sample.w_VD, state.angular_velocity);
  return TANDEM_OK;
}

std::string Arm::Trouble() const {
  const std::string line = trouble_.line();
  if (!line.empty()) return line;
  Sample sample;
  if (sample_.Read(sample) && MonotonicNowNs() - sample.time_ns > kOldNs) {
    return "a call to the device's library hangs; its own watchdog ends the force";
  }
  return {};
}

void Arm::Close() noexcept {
  if (id_ < 0) return;
  if (prepared_) dhd_.SetForceAndTorque(0, 0, 0, 0, 0, 0, id_);
  // a stop may fail, and the motors must be off
  for (int i = 0; i < kMostStops && dhd_.Stop(id_) < 0; ++i) {
    MachineClock().SleepUntil(MonotonicNowNs() + kBetweenStopsNs);
  }
  dhd_.Close(id_);
  id_ = -1;
}

}  // namespace tandem::driver
