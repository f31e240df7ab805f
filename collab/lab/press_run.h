#pragma once

#include <cstdint>
#include <memory>

#include "collab/link_conditioner.h"
#include "collab/remote_bodies.h"
#include "engine/base/result.h"
#include "engine/world/world_model.h"

namespace tandem {

/// What two users do who each hold a body of their own (paper §6.1, type-1;
/// docs/decisions/0028-live-and-type-1.md). The bodies face one another along x.
enum class PressMotion : std::uint8_t {
  kPress,  // both come by kPressTravel in half a second and stay: hands of 300 N/m
  kPush,   // the first comes by kPushTravel, the second's hand gives way: mass and damper alone
  kTap     // the first knocks once a second on the second, who holds with 400 N/m
};
const char* NameOf(PressMotion motion);
const char* NameOf(MirrorModel mirror);

struct PressCase {
  PressMotion motion = PressMotion::kPress;
  MirrorModel mirror = MirrorModel::kBlend;
  LinkConditions conditions;  // of what each hears
  double publish_hz = 1000;
  double seconds = 0;  // of the hands' motion, which begins when loops are closed; 0: LongEnough()

  /// max(12 s, 40 delays).
  double LongEnough() const;
};

/// Of two users the worse one. Forces are those that hands feel, before the guard: what the contact
/// itself says at the start of a frame is not yet what it pushes with.
struct PressResult {
  // of the last three seconds
  double unrest = 0;         // m, RMS of a body's way about its mean; of kTap from where it was a
                             // second before
  double speed = 0;          // m/s, RMS
  double mean_force = 0;     // N
  double force_std = 0;      // N
  double touches_per_s = 0;  // contacts begun anew
  // of the whole run
  double peak_force = 0;    // N
  double most_overlap = 0;  // m, of the true instances
  double most_lag = 0;      // m, of a mirror from what was received
  /// Speed below kRestSpeed, the bar of shared bodies too; of kTap: strokes differ by less than
  /// kSameStroke.
  bool calm = false;

  static constexpr double kRestSpeed = 2e-3;   // m/s
  static constexpr double kSameStroke = 1e-3;  // m
};

inline constexpr double kPressGap = 0.06;  // m between the faces at first
inline constexpr double kPressTravel = 0.05;
inline constexpr double kPushTravel = 0.16;

/// Runs two of the product's peers in virtual time: one thread, no clock; the same case gives the
/// same bits. `model`: its two moving bodies are held by one user each, the first one at lesser x.
/// Errors: the users did not hear one another.
Result<PressResult> RunPress(const PressCase& test, const std::shared_ptr<const WorldModel>& model);

}  // namespace tandem
