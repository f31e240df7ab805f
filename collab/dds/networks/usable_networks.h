#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace tandem {

/// An IPv4 address of a network interface that is up and has carrier.
struct NetworkAddress {
  unsigned interface = 0;     // the kernel's number of the interface
  std::string name;           // the interface's
  std::uint32_t address = 0;  // in network byte order, as all addresses here
  bool loopback = false;
};

/// Returns the addresses, in the order of the kernel. An interface without carrier, such as the
/// bridge of a container service that runs no container, reaches nobody and is left out.
std::vector<NetworkAddress> UsableNetworks();

/// Binds a socket so that it is reached by one interface and by this machine's own programs, or,
/// for "lo", by those alone. Empty: by all interfaces. Returns false with errno set if it cannot.
bool BindToInterface(int socket, const std::string& interface, std::uint16_t port);

/// Returns whether an address in network byte order belongs to 127.0.0.0/8.
bool IsLoopbackAddress(std::uint32_t address) noexcept;
/// Returns whether an address in network byte order is a multicast group's.
bool IsMulticastAddress(std::uint32_t address) noexcept;

}  // namespace tandem
