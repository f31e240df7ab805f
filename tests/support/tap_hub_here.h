#pragma once

#include <unistd.h>

namespace tandem::testing {

/// Returns in words why a network of real packets (TapHub) is not to be had here; null: it is.
inline const char* WhyNoTapHub() {
  const bool possible = geteuid() == 0 && access("/dev/net/tun", R_OK | W_OK) == 0 &&
                        access("/usr/sbin/ip", X_OK) == 0;
  return possible ? nullptr : "needs root, /dev/net/tun and iproute2";
}

}  // namespace tandem::testing
