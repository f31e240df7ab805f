#pragma once

#include <cstdint>

namespace tandem {

/// Returns how many UDP packets the kernel has dropped because an open socket of this process was
/// full, its receive thread not having run. It reads /proc.
std::uint64_t PacketsDroppedAtSockets();

/// Returns how many bytes a socket may keep for a thread that does not run: the kernel's limit
/// net.core.rmem_max. 0: not known.
std::uint64_t LargestSocketBuffer();

/// Bytes that a session asks for.
inline constexpr std::uint64_t kSocketBuffer = 4U << 20U;

}  // namespace tandem
