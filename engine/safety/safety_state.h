#pragma once

#include <cstdint>

namespace tandem {

/// What a guard lets a hand have, and why.
enum class SafetyState : std::uint8_t {
  kOff,        // no force yet: nobody has asked for a ramp-in
  kRamping,    // a growing share of what is asked for
  kOn,         // what is asked for, within the limits
  kDamping,    // nothing fresh for 5 ms: damping only
  kTooFast,    // the handle moves faster than a hand does: no force until it is slow again
  kExpired,    // nothing fresh for 20 ms: no force until a ramp-in is asked for
  kOverrun,    // the loop of the device stood still: no force until a ramp-in is asked for
  kFault,      // a number that is none, or a driver in trouble: no force until a person resumes
  kSuspended,  // the machine slept: no force until a ramp-in is asked for
  kStopped,    // emergency stop: no force until somebody resumes
  kSilent      // the process of the device says nothing: it stands still, or is gone
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
  std::uint64_t clamped = 0;  // frames in which more was asked for than may be given
  std::uint64_t slewed = 0;   // frames in which what was given changed as fast as it may
  std::uint64_t zeroed = 0;   // times that the force was taken away: faults, overruns, speed, sleep
  std::uint64_t expired = 0;  // times that nothing fresh had come for 5 ms
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

/// What a guard says of the energy that goes through a device's port (PassivityObserver).
struct PassivityAccount {
  bool control = false;      // damps a port that is active
  double balance_J = 0;      // taken from the hand less given to it
  double least_J = 0;        // the least of that so far
  std::uint64_t damped = 0;  // ticks in which the control damped
};

/// What a device's own guard says of itself.
struct DeviceSafety {
  SafetyState state = SafetyState::kOn;
  SafetyCounts counts;
};

}  // namespace tandem
