#include "app/device/drivers/openhaptics/stylus.h"

#include <algorithm>
#include <chrono>
#include <vector>

#include "engine/realtime/clock.h"

namespace tandem::driver {
namespace {

constexpr std::int64_t kLastTicksNs = 5'000'000;
// figures of the smallest arm, for a device that does not report its own
constexpr double kSoftestArm = 500;           // N/m that it renders stably
constexpr double kWeakestArm = 3.3;           // N
constexpr double kSixFreedomsMoment = 0.188;  // N m of the Premium 1.5

}  // namespace

Stylus::Stylus(const Hd& hd, const TandemDeviceHost& host, const Settings& settings)
    : hd_(hd), host_(&host), settings_(settings) {}

Stylus::~Stylus() {
  over_.store(true);
  if (keeper_.joinable()) keeper_.join();
  stopped_.store(true);
  // gives the scheduler time to write zero, since its last force may stay at the motors
  if (is_scheduled_) MachineClock().SleepUntil(MonotonicNowNs() + kLastTicksNs);
  EndScheduler();
}

std::string Stylus::Init() {
  std::vector<std::string> names{settings_.device};
  if (settings_.device.empty()) names = {"Default Device", "Default PHANToM"};
  std::string why;
  for (const std::string& name : names) {
    TakeErrors(hd_);  // errors of earlier calls
    device_ = hd_.InitDevice(name.c_str());
    const unsigned code = TakeErrors(hd_);
    if (device_ != kHdNoDevice && !EndsWork(code)) {
      hd_.MakeCurrentDevice(device_);
      return {};
    }
    device_ = kHdNoDevice;
    const char* message = hd_.GetErrorString(code);
    why =
        "'" + name + "' does not open (" + (message != nullptr ? message : "no reason given") + ")";
    if (code == kHdNoLicence) return why + ": the vendor's licence is missing or has ended";
    if (code == kHdAlreadyInitiated) return why + ": another program uses it: end that one";
  }
  return why + ": plug it in, switch it on, and set it up by the vendor's Touch_Setup";
}

std::string Stylus::Open() {
  if (const std::string fault = Init(); !fault.empty()) return fault;
  // a value that the device does not report keeps its default
  hd_.GetIntegerv(kHdOutputDof, &output_dof_);
  hd_.GetIntegerv(kHdCalibrationStyle, &style_);
  double peak = 0;
  double continuous = 0;
  double stiffness = 0;      // N/mm
  double workspace[6] = {};  // mm
  hd_.GetDoublev(kHdMaxForce, &peak);
  hd_.GetDoublev(kHdMaxContinuousForce, &continuous);
  hd_.GetDoublev(kHdMaxStiffness, &stiffness);
  hd_.GetDoublev(kHdUsableWorkspace, workspace);
  can_.struct_size = sizeof can_;
  can_.freedoms_in = 6;
  can_.freedoms_out = output_dof_ == 6 ? 6 : 3;
  can_.asks = 1;
  can_.peak_force = peak > 0 ? peak : kWeakestArm;
  can_.continuous_force = std::clamp(continuous, 0.0, can_.peak_force);
  can_.stiffness = stiffness > 0 ? stiffness / kHdMm : kSoftestArm;
  if (output_dof_ == 6) can_.peak_moment = can_.continuous_moment = kSixFreedomsMoment;
  for (int i = 0; i < 3; ++i) {
    can_.workspace_min[i] = kHdMm * workspace[i];
    can_.workspace_max[i] = kHdMm * workspace[3 + i];
  }
  const auto style = static_cast<unsigned>(style_);
  if (settings_.calibrates && (style & kHdEncoderReset) != 0) {
    hd_.UpdateCalibration(kHdEncoderReset);  // before the scheduler starts
  }
  if (EndsWork(TakeErrors(hd_))) {
    return "the device does not answer: switch it off and on";
  }
  return {};
}

std::string Stylus::BeginScheduler(bool is_first) {
  const auto fault_of = [this](const char* what) {
    const unsigned code = TakeErrors(hd_);
    if (!EndsWork(code)) return std::string();
    const char* message = hd_.GetErrorString(code);
    return std::string(what) + ": " + (message != nullptr ? message : "no reason given") +
           ": end other programs that use the vendor's library, and try again";
  };
  last_ns_ = 0;
  has_temperature_ = has_velocity_ = has_turn_ = Has::kUnknown;
  scheduled_ = hd_.ScheduleAsynchronous(
      [](void* of) {
        static_cast<Stylus*>(of)->Tick();
        return kHdContinue;
      },
      this, kHdHighestPriority);
  std::string fault = fault_of("the vendor's scheduler has no free place");
  if (!fault.empty()) return fault;
  is_scheduled_ = true;
  hd_.Enable(kHdForceOutput);
  fault = fault_of("the motors cannot be switched on");
  if (!fault.empty()) return fault;
  hd_.SetSchedulerRate(1000);
  // only the main thread may speak
  if (TakeErrors(hd_) != 0 && is_first) {
    host_->say(host_->context, "openhaptics: the device runs at its own rate, not 1000 Hz");
  }
  hd_.StartScheduler();
  return fault_of("the vendor's scheduler does not start");
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
  const std::string fault = BeginScheduler(true);
  if (!fault.empty()) return fault;
  keeper_ = std::thread([this] {
    Keep();
  });
  return {};
}

void Stylus::Keep() {
  int waited_ms = kReopenMs;
  while (!over_.load()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(kLookMs));
    if (!lost_.load()) {
      waited_ms = kReopenMs;  // the first attempt comes at once
      continue;
    }
    EndScheduler();
    waited_ms += kLookMs;
    if (waited_ms < kReopenMs) continue;
    waited_ms = 0;
    if (!Init().empty()) continue;
    calibration_ = TANDEM_OK;
    ticks_ = failed_ticks_ = 0;
    ramp_ = 0;
    trouble_.Say("");
    lost_.store(false);
    if (BeginScheduler(false).empty()) continue;
    lost_.store(true);
    trouble_.Say("the device is back, but the vendor's scheduler does not start");
  }
}

std::int32_t Stylus::Read(TandemDeviceState& state) noexcept {
  if (broken_.load()) return TANDEM_BROKEN;
  if (lost_.load()) return TANDEM_UNPLUGGED;
  HandleSample sample;
  if (!sample_.Read(sample)) return TANDEM_REPEATED;
  if (sample.result < 0) return sample.result;
  if (MonotonicNowNs() - sample.time_ns > kOldNs) return TANDEM_FAILED;
  state.buttons = sample.buttons;
  if (sample.time_ns == read_ns_) return TANDEM_REPEATED;
  read_ns_ = sample.time_ns;
  sample.CopyTo(state);
  return TANDEM_OK;
}

std::string Stylus::Trouble() const {
  const std::string line = trouble_.line();
  if (!line.empty()) return line;
  HandleSample sample;
  if (sample_.Read(sample) && MonotonicNowNs() - sample.time_ns > kOldNs) {
    return "the vendor's scheduler has stopped: switch the device off and on";
  }
  return {};
}

}  // namespace tandem::driver
