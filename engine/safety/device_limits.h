#pragma once

#include <algorithm>
#include <cmath>
#include <string>

namespace tandem {

/// What a device can and may render; by default what a desktop device gives and no hand is hurt by.
struct DeviceLimits {
  double force = 12.0;  // N
  double moment = 0.5;  // N m
};

/// No hand gets more, whatever a driver or a user says: docs/decisions/0033-safety.md.
inline constexpr DeviceLimits kMostForAHand{.force = 30.0, .moment = 1.0};

/// The user's setting until another is given: docs/decisions/0033-safety.md.
inline constexpr DeviceLimits kUsersDefault{.force = 3.0, .moment = 0.15};

/// A limit in force: `claimed`, at most `most`; what is not finite or not positive counts as zero.
inline double SoundLimit(double claimed, double most) noexcept {
  return std::isfinite(claimed) && claimed > 0 ? std::min(claimed, most) : 0.0;
}
/// Both limits of a device, within what the user has set and what a hand may get.
inline DeviceLimits SoundLimits(const DeviceLimits& claimed,
                                const DeviceLimits& most = kMostForAHand) noexcept {
  return {SoundLimit(claimed.force, SoundLimit(most.force, kMostForAHand.force)),
          SoundLimit(claimed.moment, SoundLimit(most.moment, kMostForAHand.moment))};
}

/// What a person is told of limits that `who` gave and that are not taken as they are; empty: they
/// are.
std::string WhatLimitsBecame(const std::string& who, const DeviceLimits& claimed);

}  // namespace tandem
