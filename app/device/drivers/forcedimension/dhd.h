#pragma once

#include <string>

#include "app/device/drivers/driver_support.h"

namespace tandem::driver {

/// The functions of Force Dimension's library that the driver calls, as the vendor's SDK 3.17
/// documents them. They are declared here because the vendor's header may not be shipped. C has no
/// default arguments, so each call names the device. Units are m, m/s, rad/s, N and N m. x points
/// to the person, y to the right, z upwards.
struct Dhd {
  int (*GetDeviceCount)();
  int (*OpenID)(char index);
  int (*Close)(char id);
  int (*Stop)(char id);
  int (*GetSystemType)(char id);
  const char* (*GetSystemName)(char id);
  bool (*HasWrist)(char id);
  bool (*HasActiveWrist)(char id);
  int (*EnableForce)(unsigned char on, char id);
  int (*EnableExpertMode)();
  int (*SetWatchdog)(unsigned char eighths_of_ms, char id);
  int (*SetMaxForce)(double most, char id);
  int (*SetMaxTorque)(double most, char id);
  int (*SetBrakes)(int on, char id);
  int (*SetGravityCompensation)(int on, char id);
  int (*GetPositionAndOrientationFrame)(double* x, double* y, double* z, double rotation[3][3],
                                        char id);
  int (*GetLinearVelocity)(double* x, double* y, double* z, char id);
  int (*GetAngularVelocityRad)(double* x, double* y, double* z, char id);
  int (*SetForceAndTorque)(double fx, double fy, double fz, double tx, double ty, double tz,
                           char id);
  unsigned (*GetButtonMask)(char id);
  int (*GetStatus)(int status[17], char id);
  int (*ErrorGetLast)();
  const char* (*ErrorGetLastStr)();
  int (*drdOpenID)(char index);
  bool (*drdIsInitialized)(char id);
  int (*drdAutoInit)(char id);
  int (*drdStop)(bool force_stays_on, char id);
};

/// Indices of values in the answer of GetStatus().
enum DhdStatus : int { kDhdConnected = 1, kDhdReset = 3, kDhdForce = 5, kDhdForceOffCause = 14 };
/// The error codes that the driver handles.
enum DhdError : int {
  kDhdCom = 2,
  kDhdBusy = 3,
  kDhdNoDriver = 4,
  kDhdNoDevice = 5,
  kDhdTimeout = 7,
  kDhdInUse = 20
};
/// The reasons why the device gives no force.
enum DhdForceOff : int {
  kDhdByButton = 1,
  kDhdBySpeed = 2,
  kDhdByWatchdog = 3,
  kDhdByUsb = 5,
  kDhdByDeadMan = 6
};

/// Loads the library: `file`; where that is empty, from the folder FDSDK or the system. Returns the
/// fault in a line; empty: none.
std::string LoadDhd(const std::string& file, Dhd& dhd);

}  // namespace tandem::driver
