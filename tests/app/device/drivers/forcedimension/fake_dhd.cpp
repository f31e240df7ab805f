// A library with the symbols of Force Dimension's libdrd, by its published interface, and a device
// that a test controls (fake_dhd.h). It counts as faults: a call for another device than the open
// one, a force before expert mode and brakes are set, a force that is no number.
#include "tests/app/device/drivers/forcedimension/fake_dhd.h"

#include <chrono>
#include <cmath>
#include <thread>

namespace {

constexpr char kId = 3;  // not the index: a driver that mixes them up is seen

tandem::testing::FakeDhd& Fake() {
  static tandem::testing::FakeDhd fake;
  return fake;
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
  return 0;
}
SHOWN int dhdEnableExpertMode() {
  return Fake().expert;
}
SHOWN int dhdSetWatchdog(unsigned char eighths, char id) {
  if (!IsMine(id)) return -1;
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
  const double all[6] = {fx, fy, fz, tx, ty, tz};
  for (int i = 0; i < 6; ++i) {
    if (!std::isfinite(all[i])) ++fake.faults;
    fake.force[i] = all[i];
  }
  if (fake.watchdog < 0 || fake.brakes != 0 || fake.force_enabled == 0) ++fake.faults;
  ++fake.forces;
  return 2;  // a motor is saturated: no error
}
SHOWN unsigned dhdGetButtonMask(char id) {
  return IsMine(id) ? Fake().buttons.load() : 0;
}
SHOWN int dhdGetStatus(int status[17], char id) {
  auto& fake = Fake();
  if (!IsMine(id)) return -1;
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
  return Fake().auto_init;
}
SHOWN int drdStop(bool, char id) {
  return IsMine(id) ? 0 : -1;
}

}  // extern "C"
