#pragma once

#include <string>

#include <netinet/in.h>
#include <sys/socket.h>

namespace tandem::driver::network {

/// An IPv4 or IPv6 address with a port.
struct Address {
  sockaddr_storage storage{};
  socklen_t length = 0;

  bool operator==(const Address& other) const;
  bool IsOfThisMachine() const;  // loopback
  std::string text() const;      // 127.0.0.1:47111, [::1]:47111
  const sockaddr* data() const { return reinterpret_cast<const sockaddr*>(&storage); }
  sockaddr* data() { return reinterpret_cast<sockaddr*>(&storage); }
};

/// Reads ADDRESS:PORT or [ADDRESS]:PORT, numeric only. False: the text is neither.
bool ReadAddress(const std::string& text, Address& address);

}  // namespace tandem::driver::network
