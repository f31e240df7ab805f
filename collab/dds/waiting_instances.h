#pragma once

#include <cstdint>

namespace tandem {

/// Bounds the instances that wait to be freed. Cyclone makes an instance for each key that a sample
/// names, before any reader sees the sample. An instance that no reader keeps goes to Cyclone's
/// thread "gc", which frees it when every other thread has moved on. That thread has no real-time
/// priority. A flood of invented keys makes instances faster than it frees them whenever it waits
/// for a core.
///
/// From here on the receive threads make no instance for a state, a picture or a sample of a
/// controller's domain while kMostWaitingInstances requests wait for "gc", and none for another
/// sample of a session while kMostWaitingOfAll do. They drop a sample with a new key and count it.
/// Samples of known keys pass. Presence, events and scenes are reliable: what is dropped of them
/// is not sent again. So a flood of what is sent again leaves room for them. A host repeats its
/// first request until it is answered. Any thread calls this; the bound holds for all domains of
/// the process.
void BoundWaitingInstances() noexcept;

inline constexpr std::int64_t kMostWaitingInstances = 1024;  // some 0.8 kB each
inline constexpr std::int64_t kMostWaitingOfAll = 8 * kMostWaitingInstances;

/// Counts the samples that the bound has dropped. Any thread calls it.
std::uint64_t InstancesRefused() noexcept;

}  // namespace tandem
