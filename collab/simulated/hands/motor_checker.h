#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "collab/simulated/breakages.h"
#include "engine/base/spatial.h"
#include "engine/safety/device_limits.h"

namespace tandem {

/// What is true of a device in a tick, and what its motor is given.
struct MotorTick {
  std::int64_t now_ns = 0;
  Twist V_WD;           // of the handle
  bool sound = true;    // the driver gives numbers and is not in trouble
  bool button = false;  // for an emergency stop: pressed
  bool ending = false;  // the device process is to end
  bool slept = false;   // the machine slept since the last tick
  // the newest order of the controller
  std::int64_t input_ns = -1;  // when the input was read that it answers; negative: none came yet
  std::uint32_t ramps = 0;
  std::uint32_t stops = 0;
  std::uint32_t resumes = 0;
  Wrench given;
};

/// What a motor may be given, tick by tick, whatever becomes of the controller, the device process
/// and the driver: the rules of docs/decisions/0033-safety.md, judged from the times, the handle
/// and the wrench alone.
///
///   finite, within the limits, changing by a sixth of them a tick at the most
///   5 ms after the input that the newest order answers: damping only, once the force has fallen
///   after 20 ms, or a loop that stood still for as long: nothing, at once
///   a stop, a fault, speed: it falls by the slew and stays away
///   what ended for good begins when it is asked for, and grows over a second; after lateness of
///   less than 20 ms over a tenth of one
class MotorChecker {
 public:
  MotorChecker(PeerId id, const DeviceLimits& limits, Breakages& breakages)
      : id_(id), limits_(limits), breakages_(&breakages) {}

  /// After every tick of the device.
  void Look(const MotorTick& tick);

 private:
  /// Something takes the force away, or has.
  struct Ended {
    bool now = false;
    std::int64_t last_ns = -1;  // when last
    int ticks = 0;              // since it began
    std::uint32_t asked = 0;    // ramp-ins and resumes asked for, when it began
  };

  void LookAtSize(const MotorTick& tick, bool may_drop);
  void LookAtDamping(const MotorTick& tick, std::int64_t age_ns);
  void LookAtEnded(const MotorTick& tick, const Ended& ended, bool for_good, const char* sort);
  void LookAtRamp(const MotorTick& tick, const Ended& ended, double ramp_s, double floor);
  std::string CauseOf(const Ended& ended) const;
  static void Note(const MotorTick& tick, bool now, Ended& ended);
  /// Whether it is beyond a share of the limits.
  bool Beyond(const Wrench& given, double share) const;
  void Break(const char* sort, const Wrench& given);

  PeerId id_;
  DeviceLimits limits_;
  Breakages* breakages_;
  std::optional<MotorTick> before_;
  Ended stopped_;
  Ended faulty_;
  Ended silent_;  // nothing fresh for 20 ms, or the loop stood still
  Ended fast_;
  Ended late_;
  Vec3 damping_ = Vec3::Zero();  // that the last tick's motion asks for
  bool begun_ = false;           // a ramp-in has been asked for
};

}  // namespace tandem
