#pragma once

// Cyclone's threads in this process have stacks of our choice, and wait by the clock that nobody
// sets. Cyclone 0.10 waits until a time of the wall clock: when that was set back by a day, its
// thread "tev" slept a day longer, unless something woke it. Meanwhile this program was announced
// to nobody, and did not find out who had fallen silent.

namespace tandem {

/// Gives each thread that Cyclone makes from here on, but those that read what others send, a stack
/// of kCycloneStackBytes. A peer locks its memory, so that a stack of ordinary size counts with all
/// of its 8 MB, and Cyclone makes one thread more when the first member of a secured session comes.
/// Cyclone's configuration takes a stack's size for some of its threads only. Any thread calls
/// this; it holds for all domains of the process.
void GiveCycloneSmallStacks() noexcept;

inline constexpr unsigned kCycloneStackBytes = 1024 * 1024;

}  // namespace tandem
