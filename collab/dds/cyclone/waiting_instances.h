#pragma once

#include <cstdint>

namespace tandem {

/// Bounds the instances that wait to be freed. Cyclone makes an instance for each key that a sample
/// names, before any reader sees the sample. An instance that no reader keeps goes to Cyclone's
/// thread "gc", which frees it when every other thread has moved on. That thread has no real-time
/// priority. A flood of invented keys makes instances faster than it frees them whenever it waits
/// for a core.
///
/// After this call the receive threads make no instance while kMostWaitingInstances requests wait
/// for "gc". This holds for a state, a picture, a file's piece or request, and a sample of a
/// controller's domain. For other samples of a session the bound is kMostWaitingOfAll. The threads
/// drop a sample with a new key and count it. Samples of known keys pass. Presence, events and
/// scenes are reliable and are not sent again once dropped. So samples that are sent again have the
/// lower bound, which leaves room for them. A host repeats its first request until it is answered.
/// Any thread may call this; the bound holds for all domains of the process.
void BoundWaitingInstances() noexcept;

inline constexpr std::int64_t kMostWaitingInstances = 1024;  // some 0.8 kB each
inline constexpr std::int64_t kMostWaitingOfAll = 8 * kMostWaitingInstances;

/// Counts the samples that the bound has dropped. Any thread may call it.
std::uint64_t InstancesRefused() noexcept;

}  // namespace tandem
