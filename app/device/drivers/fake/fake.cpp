// A device for tests and benchmarks. It records the wrenches that its motor gets, and misbehaves on
// request. Its handle moves to a place beside its home within half a second of the user's
// beginning, and may swing there. Ticks count from that beginning:
//
// | option | |
// |---|---|
// | record | file of a FakeRecord |
// | x_mm, y_mm, z_mm | place that the handle moves to, from home |
// | swing_mm, swing_hz | swing about that place, along x |
// | peak_N, peak_Nm, continuous_N, continuous_Nm | capabilities that it reports |
// | stiffness | N/m that it claims to render stably |
// | nan_at | tick whose pose is NaN |
// | fail_at | first of 50 ticks in trouble |
// | stop_at | first of 50 ticks with its stop button pressed |
// | jump_at | tick from which its handle stands 50 mm aside |
// | unplug_at | first of 200 ticks unplugged |
// | clutch_at | first of 50 ticks with its clutch button pressed |
// | hang_at, hang_ms | tick in which read() takes so long |
// | crash_at, recurse_at | tick in which it crashes, in which it runs out of its stack |
// | open_hang_ms | time that it takes to open |
// | rate_hz | rate of its own loop |
// | vendor | not 0: a thread of its own asks for the force, rate_hz times a second |
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <memory>
#include <string>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include "app/device/drivers/driver_support.h"
#include "app/device/drivers/fake/fake_record.h"
#include "app/device/tandem_device.h"
#include "engine/base/spatial.h"
#include "engine/realtime/clock.h"
#include "engine/realtime/periodic_thread.h"

namespace tandem::driver {
namespace {

constexpr double kWaySeconds = 0.5;  // time to reach its place
constexpr double kTick = 1e-3;       // s
constexpr int kVendorPriority = 40;  // as the device's loop

const TandemDeviceHost* host = nullptr;
std::string fault;

void Hang(double ms) noexcept {
  MachineClock().SleepUntil(MonotonicNowNs() + static_cast<std::int64_t>(1e6 * ms));
}

/// Recurses until there is no stack left.
int Recurse(int depth) {
  static volatile int deepest = std::numeric_limits<int>::max();
  if (depth == deepest) return 0;
  volatile char room[4096];
  room[depth % 4096] = static_cast<char>(depth);
  return Recurse(depth + 1) + room[depth % 4096];
}

/// Maps the file of a record. Null: it cannot, and `fault` says why.
FakeRecord* MapRecord(const std::string& file) {
  const int descriptor = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (descriptor < 0 || ftruncate(descriptor, sizeof(FakeRecord)) != 0) {
    if (descriptor >= 0) close(descriptor);
    fault = file + ": cannot be written";
    return nullptr;
  }
  void* data = mmap(nullptr, sizeof(FakeRecord), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE,
                    descriptor, 0);
  close(descriptor);
  if (data != MAP_FAILED) return static_cast<FakeRecord*>(data);
  fault = file + ": cannot be mapped";
  return nullptr;
}

class Fake {
 public:
  /// Opens the device. False: `fault` says why.
  bool Open(const TandemDeviceOpen& how) {
    Options options(how.options);
    for (int i = 0; i < 3; ++i) p_WD0_[i] = how.home_position[i];
    for (int i = 0; i < 4; ++i) q_WD0_.coeffs()[i] = how.home_orientation[i];
    for (int i = 0; i < 3; ++i) {
      const char* const keys[] = {"x_mm", "y_mm", "z_mm"};
      aside_[i] = 1e-3 * options.Number(keys[i], 0);
    }
    swing_ = 1e-3 * options.Number("swing_mm", 0);
    swing_hz_ = options.Number("swing_hz", 1);
    can_.struct_size = sizeof can_;
    can_.freedoms_in = can_.freedoms_out = 6;
    can_.in_scene = 1;
    can_.peak_force = options.Number("peak_N", 12);
    can_.peak_moment = options.Number("peak_Nm", 0.5);
    can_.continuous_force = options.Number("continuous_N", 12);
    can_.continuous_moment = options.Number("continuous_Nm", 0.5);
    can_.stiffness = options.Number("stiffness", 0);
    can_.rate_hz = options.Number("rate_hz", 1000);
    nan_at_ = options.Number("nan_at", 0);
    fail_at_ = options.Number("fail_at", 0);
    unplug_at_ = options.Number("unplug_at", 0);
    stop_at_ = options.Number("stop_at", 0);
    jump_at_ = options.Number("jump_at", 0);
    hang_at_ = options.Number("hang_at", 0);
    hang_ms_ = options.Number("hang_ms", 30);
    crash_at_ = options.Number("crash_at", 0);
    recurse_at_ = options.Number("recurse_at", 0);
    clutch_at_ = options.Number("clutch_at", 0);
    const double open_hang_ms = options.Number("open_hang_ms", 0);
    vendor_asks_ = options.Number("vendor", 0) != 0;
    const std::string record = options.Text("record");
    fault = options.Fault();
    if (fault.empty() && vendor_asks_ && !(can_.rate_hz >= 100 && can_.rate_hz <= 10'000)) {
      fault = "vendor=1 needs a rate_hz from 100 to 10000";
    }
    if (!fault.empty()) return false;
    can_.asks = vendor_asks_ ? 1 : 0;
    if (!record.empty() && (record_ = MapRecord(record)) == nullptr) return false;
    if (open_hang_ms > 0) Hang(open_hang_ms);
    return true;
  }
  ~Fake() {
    vendor_.reset();
    if (record_ == nullptr) return;
    Record({});
    munmap(record_, sizeof(FakeRecord));
  }

  const TandemDeviceCapabilities& can() const { return can_; }

  void Start() {
    if (!vendor_asks_) return;
    vendor_ = std::make_unique<PeriodicThread>(
        PeriodicThread::Options{.period_ns = static_cast<std::int64_t>(1e9 / can_.rate_hz),
                                .priority = kVendorPriority,
                                .name = "vendor"},
        [this](std::int64_t, std::int64_t) {
          TandemDeviceForce force{};
          force.struct_size = sizeof force;
          host->take(host->context, &force);
          Record(force);
          return true;
        });
  }

  std::int32_t Read(TandemDeviceState& state) noexcept {
    tick_ += begun_ ? 1 : 0;
    if (Within(hang_at_, 1)) Hang(hang_ms_);
    if (Within(recurse_at_, 1) && Recurse(1) == 0) std::abort();
    if (Within(crash_at_, 1)) std::abort();
    if (Within(fail_at_, 50)) return TANDEM_FAILED;
    if (Within(unplug_at_, 200)) return TANDEM_UNPLUGGED;
    const double t = kTick * static_cast<double>(tick_);
    const double s = std::clamp(t / kWaySeconds, 0.0, 1.0);
    const double omega = 2 * M_PI * swing_hz_;
    const double swing_t = std::max(0.0, t - kWaySeconds);
    Vec3 p = p_WD0_ + s * s * (3 - 2 * s) * aside_;
    Vec3 v = Vec3::Zero();
    if (s < 1) v = (6 * s * (1 - s) / kWaySeconds) * aside_;
    p.x() += swing_ * std::sin(omega * swing_t);
    if (swing_t > 0) v.x() += swing_ * omega * std::cos(omega * swing_t);
    if (jump_at_ > 0 && static_cast<double>(tick_) >= jump_at_) p.x() += 0.05;
    if (Within(nan_at_, 1)) p.x() = std::numeric_limits<double>::quiet_NaN();
    for (int i = 0; i < 3; ++i) {
      state.position[i] = p[i];
      state.velocity[i] = v[i];
    }
    for (int i = 0; i < 4; ++i) state.orientation[i] = q_WD0_.coeffs()[i];
    state.valid = TANDEM_HAS_POSE | TANDEM_HAS_VELOCITY;
    if (Within(stop_at_, 50)) state.buttons |= TANDEM_BUTTON_STOP;
    if (Within(clutch_at_, 50)) state.buttons |= TANDEM_BUTTON_CLUTCH;
    return TANDEM_OK;
  }
  void Write(const TandemDeviceForce& force) noexcept {
    begun_ = begun_ || force.begun != 0;
    if (!vendor_asks_) Record(force);
  }
  void Stop() noexcept { Record({}); }

 private:
  bool Within(double from, double length) const noexcept {
    return from > 0 && static_cast<double>(tick_) >= from &&
           static_cast<double>(tick_) < from + length;
  }
  /// Records the wrench that the motor gets.
  void Record(const TandemDeviceForce& force) noexcept {
    if (record_ == nullptr) return;
    const std::uint64_t count = record_->count.load(std::memory_order_relaxed);
    FakeRecord::Write& write = record_->writes[count % FakeRecord::kRoom];
    write.ns = MonotonicNowNs();
    std::copy_n(force.force, 3, write.force_N.begin());
    std::copy_n(force.moment, 3, write.moment_Nm.begin());
    record_->count.store(count + 1, std::memory_order_release);
  }

  Vec3 p_WD0_ = Vec3::Zero();
  Quat q_WD0_ = Quat::Identity();
  TandemDeviceCapabilities can_{};
  bool vendor_asks_ = false;
  std::unique_ptr<PeriodicThread> vendor_;  // null: write() gives the force
  FakeRecord* record_ = nullptr;
  Vec3 aside_ = Vec3::Zero();  // m
  double swing_ = 0;           // m
  double swing_hz_ = 1;
  double nan_at_ = 0, fail_at_ = 0, unplug_at_ = 0, stop_at_ = 0, jump_at_ = 0, hang_at_ = 0,
         crash_at_ = 0, clutch_at_ = 0, recurse_at_ = 0;
  double hang_ms_ = 30;
  bool begun_ = false;
  std::int64_t tick_ = 0;
};

Fake& FakeOf(TandemDevice* device) {
  return *reinterpret_cast<Fake*>(device);
}

}  // namespace
}  // namespace tandem::driver

const TandemDriver tandem_driver = {
    sizeof(TandemDriver),
    TANDEM_DEVICE_ABI_MAJOR,
    TANDEM_DEVICE_ABI_MINOR,
    0,
    "fake",
    "for tests: records the forces for its motor, and misbehaves on request",
    "record=FILE,x_mm=MM,fail_at=TICK,...",
    [](const TandemDeviceHost* given) {
      tandem::driver::host = given;
      return static_cast<std::int32_t>(TANDEM_OK);
    },
    [] {},
    [](TandemDeviceFound* found, std::int32_t room) {
      if (room < 1) return 0;
      found->present = 1;
      tandem::driver::Put(found->name, "fake");
      return 1;
    },
    [](const TandemDeviceOpen* how, TandemDevice** device) {
      auto fake = std::make_unique<tandem::driver::Fake>();
      if (!fake->Open(*how)) return static_cast<std::int32_t>(TANDEM_FAILED);
      *device = reinterpret_cast<TandemDevice*>(fake.release());
      return static_cast<std::int32_t>(TANDEM_OK);
    },
    [](TandemDevice* device) {
      delete &tandem::driver::FakeOf(device);
    },
    [](TandemDevice* device, TandemDeviceCapabilities* can) {
      *can = tandem::driver::FakeOf(device).can();
      return static_cast<std::int32_t>(TANDEM_OK);
    },
    [](TandemDevice* device) {
      tandem::driver::FakeOf(device).Start();
      return static_cast<std::int32_t>(TANDEM_OK);
    },
    [](TandemDevice* device, TandemDeviceState* state) {
      return tandem::driver::FakeOf(device).Read(*state);
    },
    [](TandemDevice* device, const TandemDeviceForce* force) {
      tandem::driver::FakeOf(device).Write(*force);
      return static_cast<std::int32_t>(TANDEM_OK);
    },
    [](TandemDevice* device) {
      tandem::driver::FakeOf(device).Stop();
    },
    [](TandemDevice* device, char* text, std::uint32_t room) {
      const char* message =
          device == nullptr ? tandem::driver::fault.c_str() : "the driver was asked to fail";
      return tandem::driver::Put(text, room, message);
    },
    nullptr};
