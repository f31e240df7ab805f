#pragma once

#include <limits>

#include "collab/dds/wire/wire.h"

namespace tandem::testing {

inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Returns whether a message that arrives so is taken, and reads what it says.
template <typename Wire, typename Message>
bool Sound(const Wire& wire, Message& message) {
  return !FromWire(wire, message).has_value();
}

}  // namespace tandem::testing
