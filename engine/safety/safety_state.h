#pragma once

#include <cstdint>

namespace tandem {

/// The state of a guard: what force it lets a hand have, and why.
enum class SafetyState : std::uint8_t {
  kOff,      // no force yet: no program has asked for a ramp-in
  kRamping,  // a growing share of the requested wrench
  kOn,       // the requested wrench, within the limits
  kDamping,  // no fresh order for 5 ms: damping only
  kTooFast,  // the handle moves faster than a hand does: no force until it is slow again
  kExpired,  // no fresh order for 20 ms: no force until a ramp-in is requested
  kOverrun,  // the loop of the device stood still: no force until a ramp-in is requested
  kFault,    // a value that is not finite, or a driver in trouble: no force until a person resumes
  kSuspended,  // the machine slept: no force until a ramp-in is requested
  kStopped,    // emergency stop: no force until a person resumes
  kSilent      // the process of the device is silent: it stands still, or is gone
};

inline const char* NameOf(SafetyState state) noexcept {
  switch (state) {
    case SafetyState::kOff:
      return "off";
    case SafetyState::kRamping:
      return "ramping";
    case SafetyState::kOn:
      return "on";
    case SafetyState::kDamping:
      return "damping";
    case SafetyState::kTooFast:
      return "too_fast";
    case SafetyState::kExpired:
      return "expired";
    case SafetyState::kOverrun:
      return "overrun";
    case SafetyState::kFault:
      return "fault";
    case SafetyState::kSuspended:
      return "suspended";
    case SafetyState::kStopped:
      return "stopped";
    case SafetyState::kSilent:
      return "silent";
  }
  return "unknown";
}

/// How often a guard acted.
struct SafetyCounts {
  std::uint64_t clamped = 0;  // frames in which more was requested than allowed
  std::uint64_t slewed = 0;   // frames in which the output changed at the greatest rate
  std::uint64_t zeroed = 0;   // times that the force was taken away: faults, overruns, speed, sleep
  std::uint64_t expired = 0;  // times that no fresh order had come for 5 ms
  std::uint64_t stops = 0;    // emergency stops

  SafetyCounts& operator+=(const SafetyCounts& other) noexcept {
    clamped += other.clamped;
    slewed += other.slewed;
    zeroed += other.zeroed;
    expired += other.expired;
    stops += other.stops;
    return *this;
  }
};

/// A guard's account of the energy that goes through a device's port (PassivityObserver).
struct PassivityAccount {
  bool control = false;      // damps a port that is active
  double balance_J = 0;      // energy taken from the hand less given to it
  double least_J = 0;        // least balance so far
  std::uint64_t damped = 0;  // ticks in which the control damped
};

/// The state of a device's own guard.
struct DeviceSafety {
  SafetyState state = SafetyState::kOn;
  SafetyCounts counts;
};

}  // namespace tandem
