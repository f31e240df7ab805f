#include "app/device/driver_device.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "engine/base/text/clean_text.h"
#include "engine/base/units.h"
#include "engine/realtime/clock.h"

namespace tandem {
namespace {

constexpr std::int64_t kFirstPoseNs = 2'000'000'000;  // longest time until a device reports its
                                                      // first pose
constexpr std::int64_t kLookNs = 2'000'000;
constexpr double kSpeedSeconds = 0.005;  // time constant of a derived speed
constexpr double kLongestStep = 0.05;    // s; after a longer step a derived speed begins again

bool IsSound(const double* numbers, int count) {
  return std::all_of(numbers, numbers + count, [](double x) {
    return std::isfinite(x);
  });
}

/// Returns a limit; 0 stands for no limit.
double OrAny(double number) {
  return number == 0 ? DeviceCapabilities::kAny : number;
}

Pose PoseIn(const TandemDeviceState& state) {
  const double* q = state.orientation;
  return {Quat(q[3], q[0], q[1], q[2]).normalized(), Vec3(state.position)};
}

bool HasSoundPose(const TandemDeviceState& state) {
  if ((state.valid & TANDEM_HAS_POSE) == 0 || !IsSound(state.position, 3) ||
      !IsSound(state.orientation, 4)) {
    return false;
  }
  const double* q = state.orientation;
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  return std::abs(norm - 1) < 0.1;
}

TandemDeviceForce ForceOf(const Wrench& F_D, bool begun) {
  TandemDeviceForce force{};
  force.struct_size = sizeof force;
  force.begun = begun ? 1 : 0;
  for (int i = 0; i < 3; ++i) {
    force.force[i] = F_D.f[i];
    force.moment[i] = F_D.tau[i];
  }
  return force;
}

}  // namespace

Result<std::unique_ptr<DriverDevice>> DriverDevice::Open(const TandemDriver& driver,
                                                         const std::string& options,
                                                         const Pose& X_WB0) {
  std::unique_ptr<DriverDevice> device(new DriverDevice(driver));
  const Result<bool> begun = device->Begin(options, X_WB0);
  if (!begun) return begun.error();
  return device;
}

Result<bool> DriverDevice::Begin(const std::string& options, const Pose& X_WB0) {
  const auto refuse = [this](const char* otherwise) {
    char text[512] = "";
    if (driver_->last_error(device_, text, sizeof text) != TANDEM_OK || text[0] == '\0') {
      std::snprintf(text, sizeof text, "%s", otherwise);
    }
    return Error{std::string(driver_->name) + ": " + text};
  };
  host_.struct_size = sizeof host_;
  host_.abi_minor = TANDEM_DEVICE_ABI_MINOR;
  host_.context = this;
  host_.say = [](void*, const char* line) {
    std::fprintf(stderr, "device: %s\n", CleanText(line).c_str());
  };
  host_.take = [](void* context, TandemDeviceForce* force) {
    auto& self = *static_cast<DriverDevice*>(context);
    const Wrench given = self.mailbox_ ? self.mailbox_->Take(MonotonicNowNs()) : Wrench{};
    *force = ForceOf(given, true);
  };
  host_.now_ns = [] {
    return MonotonicNowNs();
  };
  if (driver_->init(&host_) < 0) return refuse("the driver does not start");
  initialised_ = true;

  handle_.X_WA = X_WD0_ = X_WB0;
  TandemDeviceOpen how{};
  how.struct_size = sizeof how;
  how.options = options.c_str();
  for (int i = 0; i < 3; ++i) how.home_position[i] = X_WB0.p[i];
  for (int i = 0; i < 4; ++i) how.home_orientation[i] = X_WB0.q.coeffs()[i];
  if (driver_->open(&how, &device_) < 0 || device_ == nullptr) {
    device_ = nullptr;
    return refuse("the device does not open");
  }
  reported_.struct_size = sizeof reported_;
  if (driver_->capabilities(device_, &reported_) < 0)
    return refuse("it does not report its capabilities");
  can_ = CapabilitiesOf(reported_);
  if (reported_.asks != 0) mailbox_ = std::make_unique<VendorMailbox>(can_.peak);
  if (driver_->start(device_) < 0) return refuse("the device does not start");
  if (can_.in_scene) return true;

  // waits for the handle's first pose, which a device may know only after a while
  for (const std::int64_t until_ns = MonotonicNowNs() + kFirstPoseNs;;) {
    Read();
    if (X_VD0_ || MonotonicNowNs() > until_ns) break;
    MachineClock().SleepUntil(MonotonicNowNs() + kLookNs);
  }
  if (X_VD0_ && !can_.workspace.empty()) {
    can_.workspace.min += X_WD0_.p - X_VD0_->p;
    can_.workspace.max += X_WD0_.p - X_VD0_->p;
  }
  return true;
}

DriverDevice::~DriverDevice() {
  if (device_ != nullptr) driver_->close(device_);
  if (initialised_) driver_->deinit();
}

DeviceCapabilities DriverDevice::CapabilitiesOf(const TandemDeviceCapabilities& reported) const {
  DeviceCapabilities can;
  can.freedoms_in = static_cast<int>(std::min(reported.freedoms_in, 6U));
  can.freedoms_out = static_cast<int>(std::min(reported.freedoms_out, 6U));
  can.peak = {reported.peak_force, reported.peak_moment};
  can.continuous = {
      reported.continuous_force == 0 ? reported.peak_force : reported.continuous_force,
      reported.continuous_moment == 0 ? reported.peak_moment : reported.continuous_moment};
  const Vec3 least(reported.workspace_min);
  const Vec3 most(reported.workspace_max);
  if (least.allFinite() && most.allFinite() && (most - least).minCoeff() > 0) {
    can.workspace.min = least;
    can.workspace.max = most;
  }
  can.rate_hz = reported.rate_hz == 0 ? 1000 : reported.rate_hz;
  can.stiffness = OrAny(reported.stiffness);
  can.damping = OrAny(reported.damping);
  can.rotation_stiffness = OrAny(reported.rotation_stiffness);
  can.rotation_damping = OrAny(reported.rotation_damping);
  can.asks_us = reported.asks != 0;
  can.in_scene = reported.in_scene != 0;
  return can;
}

Anchor DriverDevice::Read() noexcept {
  TandemDeviceState state{};
  state.struct_size = sizeof state;
  const std::int32_t result = driver_->read(device_, &state);
  newest_read_.store(result, std::memory_order_relaxed);
  failed_.store(result < 0, std::memory_order_relaxed);
  if (result < 0) {
    lost_ = lost_ || result != TANDEM_FAILED;
    handle_.V_WA = {};
    buttons_ = 0;
    return handle_;
  }
  buttons_ = state.buttons;
  if (result == TANDEM_OK) Take(state);
  return handle_;
}

void DriverDevice::Take(const TandemDeviceState& state) noexcept {
  if (can_.in_scene) {
    // unchecked: the guard looks for numbers that are not finite
    const double* q = state.orientation;
    handle_.X_WA = {Quat(q[3], q[0], q[1], q[2]), Vec3(state.position)};
    handle_.V_WA = {Vec3(state.angular_velocity), Vec3(state.velocity)};
    return;
  }
  if ((state.valid & TANDEM_HAS_POSE) == 0) return;
  if (!HasSoundPose(state)) {
    failed_.store(true, std::memory_order_relaxed);
    handle_.V_WA = {};
    return;
  }
  const Pose X_VD = PoseIn(state);
  if (!X_VD0_ || lost_) {
    X_VD0_ = X_VD;
    X_WD0_ = handle_.X_WA;
    lost_ = false;
    last_ns_ = -1;
  }
  const Pose X_WD{(X_VD.q * X_VD0_->q.conjugate() * X_WD0_.q).normalized(),
                  X_WD0_.p + X_VD.p - X_VD0_->p};
  const bool has_speed = (state.valid & TANDEM_HAS_VELOCITY) != 0 && IsSound(state.velocity, 3) &&
                         IsSound(state.angular_velocity, 3);
  if (has_speed) {
    handle_.V_WA = {Vec3(state.angular_velocity), Vec3(state.velocity)};
  } else {
    Derive(X_WD, state.time_ns != 0 ? state.time_ns : MonotonicNowNs());
  }
  handle_.X_WA = X_WD;
}

void DriverDevice::Derive(const Pose& X_WD, std::int64_t time_ns) noexcept {
  const double dt = ToSeconds(time_ns - last_ns_);
  if (last_ns_ < 0 || dt > kLongestStep) {
    handle_.V_WA = {};
  } else if (dt > 0) {
    const double share = dt / (dt + kSpeedSeconds);
    const Vec3 v = (X_WD.p - handle_.X_WA.p) / dt;
    const Vec3 w = RotationVector(X_WD.q * handle_.X_WA.q.conjugate()) / dt;
    handle_.V_WA.v += share * (v - handle_.V_WA.v);
    handle_.V_WA.w += share * (w - handle_.V_WA.w);
  }
  last_ns_ = time_ns;
}

void DriverDevice::Render(const Wrench& F_D_W) noexcept {
  if (mailbox_) mailbox_->Put(F_D_W, MonotonicNowNs());
  const TandemDeviceForce force = ForceOf(F_D_W, begun_);
  if (driver_->write(device_, &force) < 0) failed_.store(true, std::memory_order_relaxed);
}

void DriverDevice::Stop() noexcept {
  if (mailbox_) mailbox_->Cut();
  if (device_ != nullptr) driver_->stop(device_);
}

ForceFetchTimes DriverDevice::fetch_times() const noexcept {
  if (!mailbox_) return {};
  return {mailbox_->taken(), mailbox_->mean_age_ns(), mailbox_->most_age_ns()};
}

std::string DriverDevice::Trouble() const {
  if (!failed()) return {};
  char text[320] = "";
  if (driver_->last_error(device_, text, sizeof text) != TANDEM_OK || text[0] == '\0') {
    return std::string(driver_->name) + ": the device has a fault that it does not explain";
  }
  return std::string(driver_->name) + ": " + text;
}

}  // namespace tandem
