#include "app/device/drivers/network/address.h"

#include <cstring>

#include <netdb.h>

namespace tandem::driver::network {
namespace {

const sockaddr_in& AsV4(const Address& address) {
  return reinterpret_cast<const sockaddr_in&>(address.storage);
}
const sockaddr_in6& AsV6(const Address& address) {
  return reinterpret_cast<const sockaddr_in6&>(address.storage);
}

}  // namespace

bool Address::operator==(const Address& other) const {
  if (storage.ss_family != other.storage.ss_family) return false;
  if (storage.ss_family == AF_INET) {
    return AsV4(*this).sin_port == AsV4(other).sin_port &&
           AsV4(*this).sin_addr.s_addr == AsV4(other).sin_addr.s_addr;
  }
  if (storage.ss_family != AF_INET6) return length == 0 && other.length == 0;
  return AsV6(*this).sin6_port == AsV6(other).sin6_port &&
         AsV6(*this).sin6_scope_id == AsV6(other).sin6_scope_id &&
         std::memcmp(&AsV6(*this).sin6_addr, &AsV6(other).sin6_addr, sizeof(in6_addr)) == 0;
}

bool Address::IsOfThisMachine() const {
  if (storage.ss_family == AF_INET) return ntohl(AsV4(*this).sin_addr.s_addr) >> 24U == 127;
  return storage.ss_family == AF_INET6 && IN6_IS_ADDR_LOOPBACK(&AsV6(*this).sin6_addr);
}

std::string Address::text() const {
  char host[64] = "";
  char port[16] = "";
  if (getnameinfo(data(), length, host, sizeof host, port, sizeof port,
                  NI_NUMERICHOST | NI_NUMERICSERV) != 0) {
    return "nowhere";
  }
  return storage.ss_family == AF_INET6 ? "[" + std::string(host) + "]:" + port
                                       : std::string(host) + ":" + port;
}

bool ReadAddress(const std::string& text, Address& address) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos || colon == 0) return false;
  std::string host = text.substr(0, colon);
  const std::string port = text.substr(colon + 1);
  if (host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string::npos) {
    return false;  // ambiguous: which colon precedes the port?
  }
  addrinfo wanted{};
  wanted.ai_family = AF_UNSPEC;
  wanted.ai_socktype = SOCK_DGRAM;
  wanted.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  if (port.empty() || getaddrinfo(host.c_str(), port.c_str(), &wanted, &found) != 0) return false;
  std::memcpy(&address.storage, found->ai_addr, found->ai_addrlen);
  address.length = found->ai_addrlen;
  freeaddrinfo(found);
  return true;
}

}  // namespace tandem::driver::network
