#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "collab/simulated/checkers/violations.h"
#include "engine/base/spatial.h"
#include "engine/safety/device_limits.h"

namespace tandem {

/// The state of a device in a tick, and the wrench that its motor gets.
struct MotorTick {
  std::int64_t now_ns = 0;
  Twist V_WD;           // twist of the handle
  bool sound = true;    // the driver gives numbers and is not in trouble
  bool button = false;  // the button for an emergency stop is pressed
  bool ending = false;  // the device process is to end
  bool slept = false;   // the machine slept since the last tick
  // the newest order of the controller
  std::int64_t input_ns = -1;  // time at which the input was read that it answers; negative: there
                               // is no order yet
  std::uint32_t ramps = 0;
  std::uint32_t stops = 0;
  std::uint32_t resumes = 0;
  Wrench given;
};

/// Judges a motor's wrench, tick by tick, whatever becomes of the controller, the device process
/// and the driver. The rules are those of docs/decisions/0033-safety.md, judged from the times, the
/// handle and the wrench alone.
///
/// - Always: finite, within the limits, and changing by at most a sixth of them in a tick.
/// - 5 ms after the input that the newest order answers: only damping, once the force has fallen.
/// - 20 ms after it, or after a loop that stood still for as long: no force, at once.
/// - After a stop, a fault or excessive speed: the force falls by the slew and stays away.
/// - A force that ended for good begins again when that is asked for, and grows over a second.
///   After lateness of less than 20 ms it grows over a tenth of a second.
class MotorChecker {
 public:
  MotorChecker(PeerId id, const DeviceLimits& limits, Violations& violations)
      : id_(id), limits_(limits), violations_(&violations) {}

  /// Judges a tick; call it after every tick of the device.
  void Check(const MotorTick& tick);

 private:
  /// A reason that takes the force away, and its times.
  struct Ended {
    bool now = false;
    std::int64_t last_ns = -1;  // time when it last held
    int ticks = 0;              // number of ticks since it began
    std::uint32_t ramps = 0;    // number of ramp-ins and resumes asked for when it began
  };

  void CheckSize(const MotorTick& tick, bool may_drop);
  void CheckDamping(const MotorTick& tick, std::int64_t age_ns);
  void CheckEnded(const MotorTick& tick, const Ended& ended, bool for_good, const char* sort);
  void CheckRamp(const MotorTick& tick, const Ended& ended, double ramp_s, double floor);
  std::string CauseOf(const Ended& ended) const;
  static void Note(const MotorTick& tick, bool now, Ended& ended);
  /// Returns whether the wrench is beyond a share of the limits.
  bool Exceeds(const Wrench& given, double share) const;
  void Break(const char* sort, const Wrench& given);

  PeerId id_;
  DeviceLimits limits_;
  Violations* violations_;
  std::optional<MotorTick> before_;
  Ended stopped_;
  Ended faulty_;
  Ended silent_;  // no fresh order for 20 ms, or the loop stood still
  Ended fast_;
  Ended late_;
  Vec3 damping_ = Vec3::Zero();  // damping that the last tick's motion asks for
  bool begun_ = false;           // a ramp-in has been asked for
};

}  // namespace tandem
