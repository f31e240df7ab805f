#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include <netinet/in.h>

namespace tandem {

/// A received packet.
struct StampedPacket {
  std::size_t bytes = 0;
  sockaddr_in from{};
  /// Time when the kernel took the packet from the network, by the monotonic clock. It excludes the
  /// time that this program then did not run.
  std::int64_t arrival_ns = 0;
};

/// Makes the kernel note when packets come to this socket.
void StampArrivals(int socket);
/// Returns the next waiting packet, or nothing if none waits. Does not wait itself.
std::optional<StampedPacket> ReceiveStamped(int socket, std::span<std::byte> room);

/// Waits for a packet, at most until that time, to a fraction of a millisecond.
void WaitForPacket(int socket, std::int64_t until_ns);

}  // namespace tandem
