#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include <netinet/in.h>

namespace tandem {

/// A packet as it came.
struct StampedPacket {
  std::size_t bytes = 0;
  sockaddr_in from{};
  /// When the kernel took it from the network, by the monotonic clock: how long this program did
  /// not run since then is not in it.
  std::int64_t arrival_ns = 0;
};

/// From now on the kernel notes down when packets come to this socket.
void StampArrivals(int socket);
/// The next packet that waits; nothing: none does. Never waits itself.
std::optional<StampedPacket> ReceiveStamped(int socket, std::span<std::byte> room);

/// Waits for a packet, until that time at the most, to a fraction of a millisecond.
void WaitForPacket(int socket, std::int64_t until_ns);

}  // namespace tandem
