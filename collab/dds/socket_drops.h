#pragma once

#include <cstdint>

namespace tandem {

/// UDP packets that the kernel dropped because a socket of this process was full, so far: its
/// receive thread did not get to run. Of sockets that are open; reads /proc.
std::uint64_t PacketsDroppedAtSockets();

/// How much a socket may keep for a thread that does not get to run, bytes: the kernel's limit,
/// net.core.rmem_max. 0: not known.
std::uint64_t LargestSocketBuffer();

/// What a session asks for.
inline constexpr std::uint64_t kSocketBuffer = 4U << 20U;

}  // namespace tandem
