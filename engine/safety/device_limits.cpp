#include "engine/safety/device_limits.h"

#include <cstdio>

namespace tandem {
namespace {

std::string WhatOneBecame(const char* of, const char* unit, double claimed, double most) {
  char text[160];
  if (!std::isfinite(claimed) || claimed <= 0) {
    std::snprintf(text, sizeof text, "%s of %g %s is no limit: it counts as zero", of, claimed,
                  unit);
    return text;
  }
  if (claimed <= most) return {};
  std::snprintf(text, sizeof text, "%s of %g %s is held to %g %s", of, claimed, unit, most, unit);
  return text;
}

}  // namespace

std::string DescribeLimitChange(const std::string& who, const DeviceLimits& claimed) {
  const std::string force = WhatOneBecame("a force", "N", claimed.force, kMostForAHand.force);
  const std::string moment = WhatOneBecame("a moment", "N m", claimed.moment, kMostForAHand.moment);
  if (force.empty() && moment.empty()) return {};
  return who + ": " + force + (force.empty() || moment.empty() ? "" : "; ") + moment;
}

}  // namespace tandem
