#pragma once

#include <cstdint>
#include <memory>

#include "collab/mirror/remote_bodies.h"
#include "collab/receive/link_conditioner.h"
#include "engine/base/result.h"
#include "engine/world/world_model.h"

namespace tandem {

/// The motions of two users who each hold their own body (paper §6.1, type-1;
/// docs/decisions/0028-live-and-type-1.md). The bodies face one another along x.
enum class PressMotion : std::uint8_t {
  kPress,  // both come by kPressTravel in half a second and stay: hands of 300 N/m
  kPush,   // the first comes by kPushTravel; the second's hand has no spring and gives way
  kTap     // the first knocks once a second on the second, who holds with 400 N/m
};
const char* NameOf(PressMotion motion);
const char* NameOf(MirrorModel mirror);

struct PressCase {
  PressMotion motion = PressMotion::kPress;
  MirrorModel mirror = MirrorModel::kCompliantMirror;
  LinkConditions conditions;  // conditions of each user's incoming messages
  double publish_hz = 1000;
  double seconds = 0;  // length of the hands' motion, which begins when loops are closed; 0: a
                       // length by the delay

  /// Returns `seconds` if set, else max(12 s, 40 delays).
  double DefaultDuration() const;
};

/// The figures of a run, each for the worse of the two users. Forces are those of the hands'
/// springs, without the guard: a contact's force at the start of a frame is not yet its applied
/// force.
struct PressResult {
  // figures of the last three seconds
  double unrest = 0;         // m, RMS distance of a body from its mean; in kTap from its place a
                             // second before
  double speed = 0;          // m/s, RMS
  double mean_force = 0;     // N
  double force_std = 0;      // N
  double touches_per_s = 0;  // number of new contacts
  // figures of the whole run
  double peak_force = 0;    // N
  double most_overlap = 0;  // m, between the true instances
  double most_lag = 0;      // m, between a mirror and the received pose
  /// Speed below kRestSpeed, which is also the bar for shared bodies. In kTap: strokes differ by
  /// less than kSameStroke.
  bool calm = false;

  static constexpr double kRestSpeed = 2e-3;   // m/s
  static constexpr double kSameStroke = 1e-3;  // m
};

inline constexpr double kPressGap = 0.06;  // m between the faces at the start
inline constexpr double kPressTravel = 0.05;
inline constexpr double kPushTravel = 0.16;

/// Runs two of the product's peers in virtual time: one thread, no clock; the same case gives the
/// same bits. Each user holds one of the two moving bodies of `model`, the first one at lesser x.
/// Error: the hands have not begun within 20 s.
Result<PressResult> RunPress(const PressCase& test, const std::shared_ptr<const WorldModel>& model);

}  // namespace tandem
