// A library with the symbols of 3D Systems' libHD, by its published interface, a scheduler of its
// own, and a device that a test controls (fake_hd.h). It keeps errors until they are asked for, the
// newest first. It counts as faults: a get of the handle or a set outside a frame (also error 402),
// a frame that nothing was written in, a second frame in a tick, a call from another thread than
// the scheduler's, a new calibration within a frame or under force, forces that are no numbers or
// above what the device gives, any call for a device that is not open, a scheduler that starts
// before a device is there.
#include "tests/app/device/drivers/openhaptics/fake_hd.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <mutex>
#include <thread>
#include <vector>

namespace {

constexpr unsigned kHandle = 7;

struct ErrorInfo {
  unsigned code;
  int internal_code;
  unsigned device;
};

tandem::testing::FakeHd& Fake() {
  static tandem::testing::FakeHd fake;
  return fake;
}

std::mutex errors_lock;
std::vector<unsigned> errors;
std::thread scheduler;
std::atomic<std::thread::id> scheduler_id;
std::atomic<bool> device_is_open{false};
std::atomic<bool> stop{false};
unsigned (*callback)(void*) = nullptr;
void* callback_of = nullptr;
bool in_frame = false;     // the scheduler is in a frame
bool wrote_force = false;  // in this frame
int frames_of_tick = 0;

void Expect(bool is_so) {
  if (!is_so) ++Fake().faults;
}
void Fail(unsigned code) {
  const std::lock_guard lock(errors_lock);
  errors.push_back(code);
}
/// Returns whether the device refuses to tell this.
bool Refuses(unsigned what) {
  Expect(device_is_open);
  if (Fake().refused_get != what) return false;
  Fail(0x100);
  return true;
}
void InFrame() {
  const bool is_so = in_frame && std::this_thread::get_id() == scheduler_id.load();
  Expect(is_so);
  if (!is_so) Fail(0x402);
}

void Run() {
  scheduler_id = std::this_thread::get_id();
  auto due = std::chrono::steady_clock::now();
  while (!stop) {
    const int hang_ms = Fake().hang_ms.exchange(0);
    if (hang_ms > 0) std::this_thread::sleep_for(std::chrono::milliseconds(hang_ms));
    frames_of_tick = 0;
    if (callback != nullptr) Expect(callback(callback_of) == 1);
    due = std::max(due + std::chrono::milliseconds(1), std::chrono::steady_clock::now());
    std::this_thread::sleep_until(due);
  }
}

}  // namespace

#define SHOWN __attribute__((visibility("default")))
extern "C" {

SHOWN tandem::testing::FakeHd* fake_hd() {
  return &Fake();
}
/// Puts the library back as after a new start of the process: it is never unloaded.
SHOWN void fake_hd_forget() {
  {
    const std::lock_guard lock(errors_lock);
    errors.clear();
  }
  callback = nullptr;
  device_is_open = false;
}

SHOWN unsigned hdInitDevice(const char* name) {
  auto& fake = Fake();
  ++fake.inits;
  const char* const names[] = {"Default Device", "Default PHANToM", "arm"};
  if (fake.init_error != 0) {
    Fail(fake.init_error);
    return 0xFFFFFFFFU;
  }
  if (name == nullptr || !fake.plugged || std::strcmp(name, names[fake.opens_as]) != 0) {
    Fail(0x300);
    return 0xFFFFFFFFU;
  }
  Expect(!device_is_open.exchange(true));
  return kHandle;
}
SHOWN void hdDisableDevice(unsigned device) {
  Expect(device == kHandle && device_is_open.exchange(false) && !Fake().running);
  ++Fake().disabled;
}
SHOWN void hdMakeCurrentDevice(unsigned device) {
  Expect(device == kHandle && device_is_open);
}
SHOWN void hdBeginFrame(unsigned device) {
  Expect(device == kHandle && !in_frame && std::this_thread::get_id() == scheduler_id.load());
  Expect(++frames_of_tick == 1);
  in_frame = true;
  wrote_force = false;
}
SHOWN void hdEndFrame(unsigned device) {
  Expect(device == kHandle && in_frame);
  Expect(wrote_force);
  in_frame = false;
  ++Fake().frames;
  if (!Fake().plugged) Fail(0x302);
  for (auto* error : {&Fake().frame_error, &Fake().later_error}) {
    const unsigned code = error->exchange(0);
    if (code != 0) Fail(code);
  }
}
SHOWN ErrorInfo hdGetError() {
  const std::lock_guard lock(errors_lock);
  if (errors.empty()) return {0, 0, kHandle};
  const unsigned code = errors.back();
  errors.pop_back();
  return {code, 0, kHandle};
}
SHOWN const char* hdGetErrorString(unsigned) {
  return "as the fake was asked to";
}
SHOWN const char* hdGetString(unsigned) {
  return "fake";
}
SHOWN void hdGetDoublev(unsigned what, double* values) {
  auto& fake = Fake();
  if (Refuses(what)) return;
  switch (what) {
    case 0x2051:
      InFrame();
      values[0] = fake.vx_mm;
      values[1] = values[2] = 0;
      return;
    case 0x2052: {
      InFrame();
      const double c = std::cos(fake.turn_y);
      const double s = std::sin(fake.turn_y);
      const double columns[16] = {c, 0, -s, 0, fake.skew, 1,         0,         0,
                                  s, 0, c,  0, fake.x_mm, fake.y_mm, fake.z_mm, 1};
      std::memcpy(values, columns, sizeof columns);
      return;
    }
    case 0x2053:
      InFrame();
      values[0] = values[1] = values[2] = 0;
      return;
    case 0x2551: {
      const double workspace[6] = {-80, -60, -35, 80, 60, 35};
      std::memcpy(values, workspace, sizeof workspace);
      return;
    }
    case 0x2602:
      *values = 0.7;
      return;
    case 0x2603:
      *values = 3.3;
      return;
    case 0x2604:
      *values = 0.88;
      return;
    case 0x2605:
      InFrame();
      for (int i = 0; i < 6; ++i) values[i] = fake.temperature;
      return;
    default:
      ++fake.faults;
  }
}
SHOWN void hdGetIntegerv(unsigned what, int* values) {
  if (Refuses(what)) return;
  switch (what) {
    case 0x2000:
      InFrame();
      *values = Fake().buttons;
      return;
    case 0x2554:
      *values = Fake().output_dof;
      return;
    case 0x2555:
      *values = Fake().style;
      return;
    default:
      ++Fake().faults;
  }
}
SHOWN void hdSetDoublev(unsigned what, const double* values) {
  InFrame();
  auto& fake = Fake();
  for (int i = 0; i < 3; ++i) {
    Expect(std::isfinite(values[i]));
    if (what == 0x2700) {
      fake.force[i] = values[i];
      fake.most_given = std::max(fake.most_given.load(), std::abs(values[i]));
      Expect(std::abs(values[i]) <= 3.3);
    }
    if (what == 0x2701) fake.torque[i] = values[i];
  }
  Expect(what == 0x2700 || (what == 0x2701 && fake.output_dof == 6));
  wrote_force = wrote_force || what == 0x2700;
  ++fake.forces;
}
SHOWN void hdEnable(unsigned what) {
  Expect(device_is_open);
  Fake().force_output = what == 0x4000;
}
SHOWN unsigned hdCheckCalibration() {
  InFrame();
  return Fake().calibration;
}
SHOWN void hdUpdateCalibration(unsigned style) {
  Expect(device_is_open && !in_frame && Fake().force[0] == 0);
  Expect(!Fake().running || std::this_thread::get_id() == scheduler_id.load());
  ++Fake().updates;
  Fake().updated_style = style;
}
SHOWN void hdStartScheduler() {
  Expect(device_is_open && callback != nullptr && !Fake().running);
  if (Fake().scheduler_fails) {
    Fail(0x304);
    return;
  }
  stop = false;
  Fake().running = true;
  scheduler = std::thread(Run);
}
SHOWN void hdStopScheduler() {
  stop = true;
  if (scheduler.joinable()) scheduler.join();
  Fake().running = false;
}
SHOWN void hdSetSchedulerRate(unsigned long rate_hz) {
  Expect(rate_hz == 1000);
  Expect(device_is_open);
  if (Fake().refuses_rate) Fail(0x101);
}
SHOWN unsigned long hdScheduleAsynchronous(unsigned (*given)(void*), void* of,
                                           unsigned short priority) {
  Expect(!Fake().running && device_is_open);
  if (Fake().schedule_error != 0) {
    Fail(Fake().schedule_error);
    return 0;
  }
  callback = given;
  callback_of = of;
  Fake().priority = priority;
  return 5;
}
SHOWN void hdUnschedule(unsigned long handle) {
  Expect(handle == 5 && !Fake().running);
  callback = nullptr;
}

}  // extern "C"
