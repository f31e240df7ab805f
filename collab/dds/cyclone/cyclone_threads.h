#pragma once

// Gives Cyclone's threads in this process stacks of a chosen size, and makes them wait by the
// monotonic clock. Cyclone 0.10 waits until a time of the wall clock. If that clock is set back by
// a day, its thread "tev" sleeps a day longer unless something wakes it. Meanwhile Cyclone does not
// announce this program and does not notice silent peers.

namespace tandem {

/// Gives each thread that Cyclone makes after this call a stack of kCycloneStackBytes. Threads that
/// read received data keep their ordinary stack. A peer locks its memory, so an ordinary stack
/// costs its full 8 MB. Cyclone makes one thread more when the first member of a secured session
/// comes. Cyclone's configuration takes a stack size for some of its threads only. Any thread may
/// call this; it holds for all domains of the process.
void SetCycloneStackSize() noexcept;

inline constexpr unsigned kCycloneStackBytes = 1024 * 1024;

}  // namespace tandem
