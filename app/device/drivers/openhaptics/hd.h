#pragma once

#include <string>

#include "app/device/drivers/driver_support.h"

namespace tandem::driver {

using HdHandle = unsigned;
struct HdErrorInfo {
  unsigned code = 0;
  int internal_code = 0;
  HdHandle device = 0;
};

/// The functions of 3D Systems' library libHD that the driver calls, as OpenHaptics 3 documents
/// them. They are declared here because the vendor's headers may not be shipped. Units are mm,
/// mm/s, rad/s, N and mN m. x points to the right, y upwards, z to the person.
struct Hd {
  HdHandle (*InitDevice)(const char* name);
  void (*DisableDevice)(HdHandle device);
  void (*MakeCurrentDevice)(HdHandle device);
  void (*BeginFrame)(HdHandle device);
  void (*EndFrame)(HdHandle device);
  HdErrorInfo (*GetError)();
  const char* (*GetErrorString)(unsigned code);
  const char* (*GetString)(unsigned what);
  void (*GetDoublev)(unsigned what, double* values);
  void (*GetIntegerv)(unsigned what, int* values);
  void (*SetDoublev)(unsigned what, const double* values);
  void (*Enable)(unsigned what);
  unsigned (*CheckCalibration)();
  void (*UpdateCalibration)(unsigned style);
  void (*StartScheduler)();
  void (*StopScheduler)();
  void (*SetSchedulerRate)(unsigned long rate_hz);
  unsigned long (*ScheduleAsynchronous)(unsigned (*callback)(void*), void* of,
                                        unsigned short priority);
  void (*Unschedule)(unsigned long handle);
};

inline constexpr double kHdMm = 1e-3;                // the library's unit of length in m
inline constexpr double kHdMilliNewtonMetre = 1e-3;  // the library's unit of moments in N m
inline constexpr HdHandle kHdNoDevice = 0xFFFFFFFFU;
inline constexpr unsigned kHdContinue = 1;
inline constexpr unsigned short kHdHighestPriority = 0xFFFF;

enum HdParameter : unsigned {
  kHdButtons = 0x2000,
  kHdVelocity = 0x2051,
  kHdTransform = 0x2052,
  kHdAngularVelocity = 0x2053,
  kHdModel = 0x2501,
  kHdUsableWorkspace = 0x2551,
  kHdOutputDof = 0x2554,
  kHdCalibrationStyle = 0x2555,
  kHdMaxStiffness = 0x2602,  // N/mm
  kHdMaxForce = 0x2603,
  kHdMaxContinuousForce = 0x2604,
  kHdMotorTemperature = 0x2605,
  kHdForce = 0x2700,
  kHdTorque = 0x2701,  // Cartesian; only on devices that drive six degrees of freedom
  kHdForceOutput = 0x4000
};
enum HdCalibration : unsigned { kHdCalibrated = 0x5000, kHdNeedsUpdate = 0x5001 };
enum HdCalibrationStyle : unsigned { kHdEncoderReset = 1, kHdAuto = 2, kHdInkwell = 4 };
enum HdError : unsigned {
  kHdWarmMotors = 0x200,
  kHdForceError = 0x204,  // the last of the errors that pass
  kHdDeviceFault = 0x300,
  kHdAlreadyInitiated = 0x301,
  kHdTimer = 0x304,
  kHdNoLicence = 0x600
};

/// Returns whether a call was refused, since the device lacks the quantity or an argument is wrong.
constexpr bool IsRefused(unsigned code) {
  return code >= 0x100 && code < kHdWarmMotors;
}
/// Returns whether the error passes when there is no force for a while.
constexpr bool IsForceError(unsigned code) {
  return code >= kHdWarmMotors && code <= kHdForceError;
}
/// Returns whether the device has to be opened again.
constexpr bool IsGone(unsigned code) {
  return code >= kHdDeviceFault && code <= kHdTimer && code != kHdAlreadyInitiated;
}
/// Returns whether the device cannot be used with this error.
constexpr bool EndsWork(unsigned code) {
  return code != 0 && !IsRefused(code) && !IsForceError(code);
}
/// Returns the worse of two errors. A device that is gone explains all others.
unsigned Worse(unsigned one, unsigned other);
/// Removes all errors that the library has stored, and returns the worst; 0: none.
unsigned TakeErrors(const Hd& hd);

/// Loads the library: `file`; where that is empty, the system's. Returns the fault in a line;
/// empty: none.
std::string LoadHd(const std::string& file, Hd& hd);

}  // namespace tandem::driver
