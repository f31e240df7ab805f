#pragma once

#include <algorithm>
#include <cmath>
#include <string>

namespace tandem {

/// The limits of what a device can and may render; by default those of a desktop device, which
/// hurts no hand.
struct DeviceLimits {
  double force = 12.0;  // N
  double moment = 0.5;  // N m
};

/// The limits for any hand, whatever a driver or a user says: docs/decisions/0033-safety.md.
inline constexpr DeviceLimits kMostForAHand{.force = 30.0, .moment = 1.0};

/// The user's setting until the user gives another: docs/decisions/0033-safety.md.
inline constexpr DeviceLimits kUsersDefault{.force = 3.0, .moment = 0.15};

/// Returns a limit in force: `claimed`, at most `most`; a value that is not finite or not positive
/// counts as zero.
inline double ValidLimit(double claimed, double most) noexcept {
  return std::isfinite(claimed) && claimed > 0 ? std::min(claimed, most) : 0.0;
}
/// Returns both limits of a device, within the user's setting and the limits for a hand.
inline DeviceLimits ValidLimits(const DeviceLimits& claimed,
                                const DeviceLimits& most = kMostForAHand) noexcept {
  return {ValidLimit(claimed.force, ValidLimit(most.force, kMostForAHand.force)),
          ValidLimit(claimed.moment, ValidLimit(most.moment, kMostForAHand.moment))};
}

/// Returns a text for a person on limits that `who` gave and that are not taken as they are; empty
/// if they are.
std::string DescribeLimitChange(const std::string& who, const DeviceLimits& claimed);

}  // namespace tandem
