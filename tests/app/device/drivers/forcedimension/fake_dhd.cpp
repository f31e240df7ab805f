// A library with the symbols of Force Dimension's libdrd, by its published interface, and a device
// that a test controls (fake_dhd.h). It counts as faults: a call for another device than the open
// one, a watchdog before expert mode, a force before watchdog and brakes are set or while the
// library itself moves the arm, a force of another thread than the one that reads poses, a force
// above the limit that was set (as in another unit), one that is no number.
#include "tests/app/device/drivers/forcedimension/fake_dhd.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <thread>

namespace {

constexpr char kId = 3;  // not the index: a driver that mixes them up is seen

tandem::testing::FakeDhd& Fake() {
  static tandem::testing::FakeDhd fake;
  return fake;
}

std::atomic<std::thread::id> reader;       // the thread that reads poses
std::atomic<bool> library_moves{false};    // drdAutoInit() to drdStop()
std::atomic<std::int64_t> newest_force{};  // ns; 0: none

std::int64_t Now() {
  return std::chrono::steady_clock::now().time_since_epoch().count();
}

bool IsMine(char id) {
  const bool is_mine = id == kId && Fake().opened;
  if (!is_mine) ++Fake().faults;
  return is_mine;
}

int Open(char index) {
  auto& fake = Fake();
  ++fake.opens;
  if (fake.open_error != 0 || index >= fake.devices || fake.connected == 0) {
    if (fake.open_error == 0) fake.error = 5;
    return -1;
  }
  if (fake.opened.exchange(true)) ++fake.faults;
  fake.watchdog = fake.brakes = -1;
  fake.most_force = -1;
  fake.force_enabled = 0;
  reader = std::thread::id();
  newest_force = 0;
  library_moves = false;
  return kId;
}

}  // namespace

#define SHOWN __attribute__((visibility("default")))
extern "C" {

SHOWN tandem::testing::FakeDhd* fake_dhd() {
  return &Fake();
}

SHOWN int dhdGetDeviceCount() {
  return Fake().devices;
}
SHOWN int dhdOpenID(char index) {
  return Open(index);
}
SHOWN int drdOpenID(char index) {
  return Open(index);
}
SHOWN int dhdClose(char id) {
  if (!IsMine(id)) return -1;
  ++Fake().closes;
  Fake().opened = false;
  return 0;
}
SHOWN int dhdStop(char id) {
  if (!IsMine(id)) return -1;
  ++Fake().stops;
  if (Fake().failing_stops > 0) {
    --Fake().failing_stops;
    return -1;
  }
  for (auto& force : Fake().force) force = 0;
  return 0;
}
SHOWN int dhdGetSystemType(char id) {
  return IsMine(id) ? Fake().type.load() : -1;
}
SHOWN const char* dhdGetSystemName(char) {
  return "fake";
}
SHOWN bool dhdHasWrist(char id) {
  return IsMine(id) && Fake().wrist;
}
SHOWN bool dhdHasActiveWrist(char id) {
  return IsMine(id) && Fake().active_wrist;
}
SHOWN int dhdEnableForce(unsigned char on, char id) {
  if (!IsMine(id)) return -1;
  Fake().force_enabled += on != 0 ? 1 : 0;
  if (Fake().acts_as_watchdog && Fake().force_off_cause == 3) Fake().force_off_cause = 0;
  newest_force = 0;
  return 0;
}
SHOWN int dhdEnableExpertMode() {
  Fake().expert_on = Fake().expert >= 0;
  return Fake().expert;
}
SHOWN int dhdSetWatchdog(unsigned char eighths, char id) {
  if (!IsMine(id)) return -1;
  if (!Fake().expert_on) ++Fake().faults;
  Fake().watchdog = eighths;
  return 0;
}
SHOWN int dhdSetMaxForce(double most, char id) {
  if (!IsMine(id)) return -1;
  Fake().most_force = most;
  return 0;
}
SHOWN int dhdSetMaxTorque(double most, char id) {
  if (!IsMine(id)) return -1;
  Fake().most_torque = most;
  return 0;
}
SHOWN int dhdSetBrakes(int on, char id) {
  if (!IsMine(id)) return -1;
  Fake().brakes = on;
  return 0;
}
SHOWN int dhdSetGravityCompensation(int on, char id) {
  if (!IsMine(id)) return -1;
  Fake().gravity = on;
  return 0;
}
SHOWN int dhdGetPositionAndOrientationFrame(double* x, double* y, double* z, double R[3][3],
                                            char id) {
  auto& fake = Fake();
  if (!IsMine(id)) return -1;
  ++fake.poses;
  reader = std::this_thread::get_id();
  const int hang_ms = fake.hang_ms.exchange(0);
  if (hang_ms > 0) std::this_thread::sleep_for(std::chrono::milliseconds(hang_ms));
  if (fake.connected == 0) {
    fake.error = 2;
    return -1;
  }
  if (fake.read_result < 0) return fake.read_result;
  *x = fake.x;
  *y = fake.y;
  *z = fake.z;
  const double c = std::cos(fake.turn_z);
  const double s = std::sin(fake.turn_z);
  const double turned[3][3] = {{c, -s, 0}, {s, c, 0}, {0, 0, 1}};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) R[i][j] = turned[i][j];
  }
  return fake.read_result;
}
SHOWN int dhdGetLinearVelocity(double* x, double* y, double* z, char id) {
  auto& fake = Fake();
  if (!IsMine(id) || fake.velocity_result < 0 || fake.connected == 0) return -1;
  *x = fake.vx;
  *y = fake.vy;
  *z = fake.vz;
  return 0;
}
SHOWN int dhdGetAngularVelocityRad(double* x, double* y, double* z, char id) {
  if (!IsMine(id) || Fake().velocity_result < 0) return -1;
  *x = *y = *z = 0;
  return 0;
}
SHOWN int dhdSetForceAndTorque(double fx, double fy, double fz, double tx, double ty, double tz,
                               char id) {
  auto& fake = Fake();
  if (!IsMine(id)) return -1;
  if (fake.force_result < 0) return fake.force_result;
  const std::int64_t last = newest_force.exchange(Now());
  if (fake.acts_as_watchdog && last != 0 && Now() - last > 125'000L * fake.watchdog) {
    fake.force_off_cause = 3;
    ++fake.watchdog_trips;
  }
  const double all[6] = {fx, fy, fz, tx, ty, tz};
  const bool is_any = std::any_of(all, all + 6, [](double one) {
    return one != 0;
  });
  if (is_any && std::this_thread::get_id() != reader.load()) ++fake.faults;
  if (library_moves || std::hypot(fx, fy, fz) > fake.most_force) ++fake.faults;
  for (int i = 0; i < 6; ++i) {
    if (!std::isfinite(all[i])) ++fake.faults;
    fake.force[i] = all[i];
    fake.most_given = std::max(fake.most_given.load(), std::abs(all[i]));
  }
  if (fake.watchdog < 0 || fake.brakes != 0 || fake.force_enabled == 0) ++fake.faults;
  ++fake.forces;
  return fake.force_result;
}
SHOWN unsigned dhdGetButtonMask(char id) {
  return IsMine(id) ? Fake().buttons.load() : 0;
}
SHOWN int dhdGetStatus(int status[17], char id) {
  auto& fake = Fake();
  if (!IsMine(id)) return -1;
  if (fake.status_result < 0) return fake.status_result;
  for (int i = 0; i < 17; ++i) status[i] = 0;
  status[1] = fake.connected;
  status[3] = fake.reset;
  status[5] = fake.force_off_cause == 0 ? 1 : 0;
  status[14] = fake.force_off_cause;
  return 0;
}
SHOWN int dhdErrorGetLast() {
  return Fake().open_error != 0 ? Fake().open_error.load() : Fake().error.load();
}
SHOWN const char* dhdErrorGetLastStr() {
  return Fake().open_error == 3 ? "device is busy" : "communication error";
}
SHOWN bool drdIsInitialized(char id) {
  return IsMine(id) && Fake().initialised;
}
SHOWN int drdAutoInit(char id) {
  if (!IsMine(id)) return -1;
  ++Fake().auto_inits;
  library_moves = true;
  return Fake().auto_init;
}
SHOWN int drdStop(bool, char id) {
  if (!IsMine(id)) return -1;
  library_moves = false;
  return 0;
}

}  // extern "C"
