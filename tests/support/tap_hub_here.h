#pragma once

#include <unistd.h>

namespace tandem::testing {

/// What a network of real packets (TapHub) lacks here, in words; null: nothing.
inline const char* WhyNoTapHub() {
  const bool possible = geteuid() == 0 && access("/dev/net/tun", R_OK | W_OK) == 0 &&
                        access("/usr/sbin/ip", X_OK) == 0;
  return possible ? nullptr : "needs root, /dev/net/tun and iproute2";
}

}  // namespace tandem::testing
