#include "collab/dds/networks/usable_networks.h"

#include <cerrno>
#include <cstring>

#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>

namespace tandem {

std::vector<NetworkAddress> UsableNetworks() {
  std::vector<NetworkAddress> usable;
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return usable;
  for (const ifaddrs* i = list; i != nullptr; i = i->ifa_next) {
    if (i->ifa_addr == nullptr || i->ifa_addr->sa_family != AF_INET) continue;
    // loopback has no carrier to lose
    const unsigned needed = (i->ifa_flags & IFF_LOOPBACK) != 0 ? IFF_UP : IFF_UP | IFF_RUNNING;
    if ((i->ifa_flags & needed) != needed) continue;
    sockaddr_in address{};
    std::memcpy(&address, i->ifa_addr, sizeof address);
    // an address may have a name of its own, "eth0:1"
    std::string name(i->ifa_name);
    name = name.substr(0, name.find(':'));
    const unsigned index = if_nametoindex(name.c_str());
    if (index == 0 || address.sin_addr.s_addr == 0) continue;
    usable.push_back({.interface = index,
                      .name = name,
                      .address = address.sin_addr.s_addr,
                      .loopback = (i->ifa_flags & IFF_LOOPBACK) != 0});
  }
  freeifaddrs(list);
  return usable;
}

bool BindToInterface(int socket, const std::string& interface, std::uint16_t port) {
  sockaddr_in own{};
  own.sin_family = AF_INET;
  own.sin_port = htons(port);
  if (!interface.empty()) {
    errno = EADDRNOTAVAIL;
    for (const NetworkAddress& one : UsableNetworks()) {
      if (own.sin_addr.s_addr == 0 && one.name == interface) own.sin_addr.s_addr = one.address;
    }
    if (own.sin_addr.s_addr == 0) return false;
    // without it, other interfaces carry packets to this one's address; old kernels want rights
    if (interface != "lo") {
      setsockopt(socket, SOL_SOCKET, SO_BINDTODEVICE, interface.data(),
                 static_cast<socklen_t>(interface.size()));
    }
  }
  return bind(socket, reinterpret_cast<const sockaddr*>(&own), sizeof own) == 0;
}

bool IsLoopbackAddress(std::uint32_t address) noexcept {
  return ntohl(address) >> 24U == 127;
}

bool IsMulticastAddress(std::uint32_t address) noexcept {
  return ntohl(address) >> 28U == 14;
}

}  // namespace tandem
