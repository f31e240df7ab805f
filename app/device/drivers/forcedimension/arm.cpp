#include "app/device/drivers/forcedimension/arm.h"

#include <algorithm>
#include <array>

#include "engine/base/spatial.h"
#include "engine/realtime/clock.h"

namespace tandem::driver {
namespace {

constexpr int kArmPriority = 41;  // above the device's loop: the motors are served first
constexpr int kMostStops = 50;    // attempts to end the force
constexpr std::int64_t kBetweenStopsNs = 2'000'000;

struct Model {
  int type;
  double force;      // N
  double moment;     // N m of an active wrist
  double stiffness;  // N/m that its loop renders stably; 0: unknown
};
// published figures; a model that is not listed gets the lowest of them
constexpr std::array kModels{Model{33, 12, 0, 5000}, Model{34, 12, 0, 5000}, Model{36, 12, 0, 5000},
                             Model{35, 12, 0, 5000}, Model{37, 12, 0, 5000}, Model{60, 8, 0, 0},
                             Model{63, 20, 0, 0},    Model{104, 12, 0.2, 0}, Model{105, 12, 0.2, 0},
                             Model{108, 12, 0.2, 0}, Model{109, 12, 0.2, 0}};
constexpr Model kUnknownModel{0, 8, 0.2, 0};

Model ModelOf(int type) {
  const auto found = std::ranges::find(kModels, type, &Model::type);
  return found == kModels.end() ? kUnknownModel : *found;
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
    const char* message = dhd_.ErrorGetLastStr();
    std::string why = "the device does not open: ";
    why += message != nullptr ? message : "no reason given";
    if (fault == kDhdNoDriver) {
      why += ": you have no right to use its USB driver: see 'tandem devices'";
    } else if (fault == kDhdBusy || fault == kDhdInUse) {
      why += ": another program uses it: end that one";
    } else {
      why += ": plug it in and switch it on";
    }
    return why;
  }
  const Model model = ModelOf(dhd_.GetSystemType(id_));
  has_wrist_ = dhd_.HasWrist(id_);
  drives_wrist_ = dhd_.HasActiveWrist(id_);
  most_force_ = model.force;
  most_moment_ = drives_wrist_ ? model.moment : 0;
  return settings_.calibrates ? std::string() : Prepare();
}

std::string Arm::FindReference() {
  if (!dhd_.drdIsInitialized(id_)) {
    host_->say(host_->context,
               "forcedimension: the arm moves by itself now: keep your hands off it");
    if (dhd_.drdAutoInit(id_) < 0) {
      return "the device did not find its reference: move the handle to the middle, and try again";
    }
  }
  // ends the library's own control of the arm, and leaves the force on
  if (dhd_.drdStop(true, id_) < 0) {
    return "the library does not release the arm: switch the device off and on, and try again";
  }
  return {};
}

std::string Arm::Prepare() {
  const bool is_guarded = dhd_.EnableExpertMode() >= 0 && dhd_.SetWatchdog(kWatchdog, id_) >= 0;
  if (!is_guarded) {
    return "the watchdog of the device cannot be set; without it a crash may leave a force on";
  }
  if (dhd_.SetMaxForce(most_force_, id_) < 0 ||
      (drives_wrist_ && dhd_.SetMaxTorque(most_moment_, id_) < 0)) {
    return "the force limit of the device cannot be set";
  }
  if (dhd_.SetBrakes(0, id_) < 0 || dhd_.EnableForce(1, id_) < 0 ||
      dhd_.SetForceAndTorque(0, 0, 0, 0, 0, 0, id_) < 0) {
    const char* message = dhd_.ErrorGetLastStr();
    return std::string("the motors of the device cannot be switched on: ") +
           (message != nullptr ? message : "no reason given");
  }
  // active while forces are sent; a device without it goes without
  dhd_.SetGravityCompensation(1, id_);
  prepared_ = true;
  status_ = TANDEM_FAILED;  // until the first look
  status_ns_ = 0;
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

std::string Arm::Start() {
  if (settings_.calibrates) {
    std::string fault = FindReference();
    if (fault.empty()) fault = Prepare();
    if (!fault.empty()) return fault;
  }
  thread_ = std::make_unique<PeriodicThread>(
      PeriodicThread::Options{
          .period_ns = kPeriodNs, .priority = kArmPriority, .name = "forcedimension"},
      [this](std::int64_t, std::int64_t now_ns) {
        Turn(now_ns);
        return true;
      });
  return {};
}

std::int32_t Arm::Read(TandemDeviceState& state) noexcept {
  HandleSample sample;
  if (!sample_.Read(sample)) return TANDEM_REPEATED;
  if (MonotonicNowNs() - sample.time_ns > kOldNs) return TANDEM_FAILED;
  if (sample.result < 0) return sample.result;
  if (sample.time_ns == read_ns_) {
    state.buttons = sample.buttons;
    return TANDEM_REPEATED;
  }
  read_ns_ = sample.time_ns;
  sample.CopyTo(state);
  return TANDEM_OK;
}

std::string Arm::Trouble() const {
  const std::string line = trouble_.line();
  if (!line.empty()) return line;
  HandleSample sample;
  if (sample_.Read(sample) && MonotonicNowNs() - sample.time_ns > kOldNs) {
    return "a call to the device's library does not return; the device's watchdog ends the force";
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
