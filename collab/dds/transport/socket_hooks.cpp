// Replaces functions of Cyclone, because Cyclone finds these before its own. Cyclone binds its
// sockets to all addresses, whatever its configuration says, and learns of networks only once, when
// a domain is made. These functions give a domain's sockets to DomainNetworks, which knows better,
// and what comes to PacketFilter. They stand in one file, so that no program has some of them
// alone.

#include <array>
#include <atomic>
#include <cstring>
#include <memory>
#include <mutex>
#include <vector>

#include <dds/ddsrt/heap.h>
#include <dds/ddsrt/ifaddrs.h>
#include <dds/ddsrt/sockets.h>
#include <dds/ddsrt/string.h>
#include <dlfcn.h>
#include <net/if.h>
#include <netinet/in.h>

#include "collab/dds/networks/domain_networks.h"
#include "collab/dds/networks/live_domains.h"
#include "collab/dds/transport/packet_filter.h"

namespace tandem {
namespace {

// Descriptors beyond are refused, so that no socket is without its bound.
constexpr std::size_t kMostDescriptors = 4096;

struct Domains {
  std::array<std::atomic<DomainNetworks*>, kMostDescriptors> of_socket{};
  std::mutex mutex;
  std::vector<std::unique_ptr<DomainNetworks>> alive;
};

// never destroyed, because Cyclone's threads may outlive main()
Domains& SharedDomains() {
  static auto& domains = *new Domains;
  return domains;
}

struct BeingMade {
  DomainNetworks* networks = nullptr;
  std::uint32_t announced = 0;
  bool bound = false;
};
thread_local BeingMade t_being_made;

void Forget(const DomainNetworks* networks) {
  Domains& domains = SharedDomains();
  const std::scoped_lock lock(domains.mutex);
  std::erase_if(domains.alive, [networks](const auto& one) {
    return one.get() == networks;
  });
}

template <typename Function>
Function* CyclonesOwn(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

sockaddr* CopyOf(std::uint32_t address) {
  sockaddr_in made{};
  made.sin_family = AF_INET;
  made.sin_addr.s_addr = address;
  void* const copy = ddsrt_malloc(sizeof made);
  std::memcpy(copy, &made, sizeof made);
  return static_cast<sockaddr*>(copy);
}

}  // namespace

NewDomainNetworks::NewDomainNetworks(const std::string& interface, std::uint32_t domain,
                                     bool proves_members, std::uint32_t announced) {
  Domains& domains = SharedDomains();
  const std::scoped_lock lock(domains.mutex);
  domains.alive.push_back(std::make_unique<DomainNetworks>(interface, domain, proves_members));
  t_being_made = {domains.alive.back().get(), announced, false};
}

NewDomainNetworks::~NewDomainNetworks() {
  // a domain without sockets was not made
  if (!t_being_made.bound) Forget(t_being_made.networks);
  t_being_made = {};
}

DomainNetworks* NetworksOfSocket(int socket) noexcept {
  if (socket < 0 || static_cast<std::size_t>(socket) >= kMostDescriptors) return nullptr;
  return SharedDomains().of_socket[static_cast<std::size_t>(socket)].load(
      std::memory_order_acquire);
}

void ForEachLiveDomain(const std::function<void(DomainNetworks&)>& use) {
  Domains& domains = SharedDomains();
  const std::scoped_lock lock(domains.mutex);
  for (const std::unique_ptr<DomainNetworks>& one : domains.alive) use(*one);
}

namespace {

dds_return_t BindBounded(ddsrt_socket_t socket, const sockaddr* address, socklen_t size) {
  static const auto cyclones = CyclonesOwn<decltype(ddsrt_bind)>("ddsrt_bind");
  DomainNetworks* const networks = t_being_made.networks;
  if (networks == nullptr || address->sa_family != AF_INET) return cyclones(socket, address, size);
  if (static_cast<std::size_t>(socket) >= kMostDescriptors) return DDS_RETCODE_OUT_OF_RESOURCES;
  sockaddr_in own{};
  std::memcpy(&own, address, sizeof own);
  if (!networks->Bind(socket, own.sin_addr.s_addr)) return DDS_RETCODE_ERROR;
  t_being_made.bound = true;
  SharedDomains().of_socket[static_cast<std::size_t>(socket)].store(networks,
                                                                    std::memory_order_release);
  return cyclones(socket, reinterpret_cast<const sockaddr*>(&own), sizeof own);
}

void ReleaseSocket(ddsrt_socket_t socket) {
  DomainNetworks* const networks = NetworksOfSocket(socket);
  if (networks == nullptr) return;
  SharedDomains().of_socket[static_cast<std::size_t>(socket)].store(nullptr,
                                                                    std::memory_order_release);
  // a domain that is being made goes with NewDomainNetworks
  if (!networks->Release(socket)) return;
  if (networks == t_being_made.networks) {
    t_being_made.bound = false;
  } else {
    Forget(networks);
  }
}

}  // namespace
}  // namespace tandem

extern "C" {

dds_return_t ddsrt_bind(ddsrt_socket_t socket, const sockaddr* address, socklen_t size) {
  return tandem::BindBounded(socket, address, size);
}

dds_return_t ddsrt_close(ddsrt_socket_t socket) {
  static const auto cyclones = tandem::CyclonesOwn<decltype(ddsrt_close)>("ddsrt_close");
  tandem::ReleaseSocket(socket);
  return cyclones(socket);
}

dds_return_t ddsrt_setsockopt(ddsrt_socket_t socket, int32_t level, int32_t name, const void* value,
                              socklen_t size) {
  static const auto cyclones = tandem::CyclonesOwn<decltype(ddsrt_setsockopt)>("ddsrt_setsockopt");
  tandem::DomainNetworks* const networks = tandem::NetworksOfSocket(socket);
  if (networks == nullptr || networks->reach() == tandem::DomainNetworks::Reach::kLoopback ||
      level != IPPROTO_IP) {
    return cyclones(socket, level, name, value, size);
  }
  // each packet names its network
  if (name == IP_MULTICAST_IF) return DDS_RETCODE_OK;
  if (name != IP_ADD_MEMBERSHIP && name != IP_DROP_MEMBERSHIP) {
    return cyclones(socket, level, name, value, size);
  }
  ip_mreq request{};
  std::memcpy(&request, value, std::min<std::size_t>(size, sizeof request));
  // memberships end with their socket
  if (name == IP_ADD_MEMBERSHIP) networks->Join(socket, request.imr_multiaddr.s_addr);
  return DDS_RETCODE_OK;
}

dds_return_t ddsrt_sendmsg(ddsrt_socket_t socket, const ddsrt_msghdr_t* message, int flags,
                           ssize_t* sent) {
  static const auto cyclones = tandem::CyclonesOwn<decltype(ddsrt_sendmsg)>("ddsrt_sendmsg");
  tandem::DomainNetworks* const networks = tandem::NetworksOfSocket(socket);
  if (networks == nullptr || networks->reach() == tandem::DomainNetworks::Reach::kLoopback) {
    return cyclones(socket, message, flags, sent);
  }
  *sent = networks->Send(socket, *message, flags);
  // Cyclone passes over this code without a line in its log
  return *sent >= 0 ? DDS_RETCODE_OK : DDS_RETCODE_NO_CONNECTION;
}

// For a dropped packet it returns that nobody is there, as after an ICMP message. Cyclone passes
// over that code without a line in its log.
dds_return_t ddsrt_recvmsg(ddsrt_socket_t socket, ddsrt_msghdr_t* message, int flags,
                           ssize_t* received) {
  static const auto cyclones = tandem::CyclonesOwn<decltype(ddsrt_recvmsg)>("ddsrt_recvmsg");
  alignas(cmsghdr) std::array<std::byte, CMSG_SPACE(sizeof(in_pktinfo))> beside;
  ddsrt_msghdr_t with_way = *message;
  with_way.msg_control = beside.data();
  with_way.msg_controllen = beside.size();
  const dds_return_t code = cyclones(socket, &with_way, flags, received);
  message->msg_namelen = with_way.msg_namelen;
  message->msg_flags = with_way.msg_flags;
  if (code == DDS_RETCODE_OK && *received > 0 &&
      tandem::JudgeArrival(with_way, static_cast<std::size_t>(*received),
                           tandem::NetworksOfSocket(socket)) != tandem::PacketDrop::kNone) {
    *received = 0;
    return DDS_RETCODE_NO_CONNECTION;
  }
  return code;
}

// Shows a domain that is being made one network that leads everywhere.
dds_return_t ddsrt_getifaddrs(ddsrt_ifaddrs_t** list, const int* families) {
  static const auto cyclones = tandem::CyclonesOwn<decltype(ddsrt_getifaddrs)>("ddsrt_getifaddrs");
  const tandem::DomainNetworks* const networks = tandem::t_being_made.networks;
  if (networks == nullptr || networks->reach() == tandem::DomainNetworks::Reach::kLoopback) {
    return cyclones(list, families);
  }
  auto* const one = static_cast<ddsrt_ifaddrs_t*>(ddsrt_calloc(1, sizeof(ddsrt_ifaddrs_t)));
  one->name = ddsrt_strdup("networks");
  one->index = 1;
  one->flags = IFF_UP | IFF_RUNNING | IFF_MULTICAST;
  one->type = DDSRT_IFTYPE_WIRED;
  one->addr = tandem::CopyOf(tandem::t_being_made.announced);
  one->netmask = tandem::CopyOf(0);
  *list = one;
  return DDS_RETCODE_OK;
}
}
