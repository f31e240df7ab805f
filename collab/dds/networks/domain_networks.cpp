#include "collab/dds/networks/domain_networks.h"

#include <algorithm>
#include <cstring>
#include <random>

#include <netinet/in.h>

#include "collab/dds/networks/usable_networks.h"
#include "engine/base/units.h"
#include "engine/realtime/clock.h"

namespace tandem {
namespace {

// Others send what all of a session get only where one of them was heard lately.
constexpr std::int64_t kHeardNs = 10 * kSecondNs;
// An address at which nothing has come for this time is nobody's way to this program.
constexpr std::int64_t kInUseNs = 5 * kSecondNs;

std::uint32_t LoopbackAddress() noexcept {
  return htonl(INADDR_LOOPBACK);
}

std::size_t SizeOf(const msghdr& packet) {
  std::size_t size = 0;
  for (std::size_t i = 0; i < packet.msg_iovlen; ++i) size += packet.msg_iov[i].iov_len;
  return size;
}

std::uint16_t PortOf(int socket) {
  sockaddr_in own{};
  socklen_t size = sizeof own;
  if (getsockname(socket, reinterpret_cast<sockaddr*>(&own), &size) != 0) return 0;
  return ntohs(own.sin_port);
}

DomainNetworks::Reach ReachOf(const std::string& interface) {
  if (interface.empty()) return DomainNetworks::Reach::kAll;
  return interface == "lo" ? DomainNetworks::Reach::kLoopback : DomainNetworks::Reach::kInterface;
}

}  // namespace

DomainNetworks::DomainNetworks(const std::string& interface, std::uint32_t domain,
                               bool proves_members)
    : reach_(ReachOf(interface)), domain_(domain) {
  interface.copy(name_.data(), name_.size() - 1);
  if (!proves_members) return;
  std::random_device random;
  sources_.emplace(random() | std::uint64_t{random()} << 32U);
}

bool DomainNetworks::Uses(const NetworkTable::Row& row) const noexcept {
  switch (reach_) {
    case Reach::kLoopback:
      return row.loopback;
    case Reach::kInterface:
      return row.name == name_;
    case Reach::kAll:
      break;
  }
  return true;
}

bool DomainNetworks::Hears(const Arrival& arrival) const noexcept {
  switch (reach_) {
    case Reach::kLoopback:
      // the kernel drops what claims such an address and comes from elsewhere
      return IsLoopbackAddress(arrival.from);
    case Reach::kInterface:
      return std::ranges::any_of(CurrentNetworks().used(), [&](const NetworkTable::Row& row) {
        return row.interface == arrival.interface && (row.loopback || Uses(row));
      });
    case Reach::kAll:
      break;
  }
  return true;
}

bool DomainNetworks::Bind(int socket, std::uint32_t& address) {
  const int yes = 1;
  if (reach_ == Reach::kLoopback) {
    address = LoopbackAddress();
  } else if (setsockopt(socket, IPPROTO_IP, IP_PKTINFO, &yes, sizeof yes) != 0) {
    return false;
  } else {
    // also where DDS names an address: the kernel chooses by the route, and addresses change
    address = INADDR_ANY;
  }
  const std::scoped_lock lock(mutex_);
  sockets_.push_back(socket);
  return true;
}

void DomainNetworks::Join(int socket, std::uint32_t group) {
  const std::uint16_t port = PortOf(socket);
  const std::scoped_lock lock(mutex_);
  // the group of discovery has the lower port
  const std::uint16_t lowest = discovery_port_.load();
  if (lowest == 0 || port < lowest) discovery_port_.store(port);
  JoinAll(memberships_.emplace_back(Membership{socket, group}), CurrentNetworks());
}

void DomainNetworks::JoinAll(const Membership& membership, const NetworkTable& table) const {
  for (const NetworkTable::Row& row : table.used()) {
    if (!Uses(row)) continue;
    ip_mreqn request{};
    request.imr_multiaddr.s_addr = membership.group;
    request.imr_ifindex = static_cast<int>(row.interface);
    // fails where it is a member already; a network that has no groups is reached without
    setsockopt(membership.socket, IPPROTO_IP, IP_ADD_MEMBERSHIP, &request, sizeof request);
  }
}

bool DomainNetworks::Release(int socket) {
  const std::scoped_lock lock(mutex_);
  std::erase(sockets_, socket);
  std::erase_if(memberships_, [socket](const Membership& one) {
    return one.socket == socket;
  });
  return sockets_.empty();
}

void DomainNetworks::Note(const Arrival& arrival, std::int64_t now_ns) noexcept {
  for (Heard& heard : heard_) {
    std::uint32_t known = heard.address.load(std::memory_order_relaxed);
    if (known == 0 && heard.address.compare_exchange_strong(known, arrival.at)) known = arrival.at;
    if (known != arrival.at) continue;
    heard.interface.store(arrival.interface, std::memory_order_relaxed);
    heard.any_ns.store(now_ns, std::memory_order_relaxed);
    if (!arrival.to_group) heard.unicast_ns.store(now_ns, std::memory_order_relaxed);
    return;
  }
}

bool DomainNetworks::WasHeardOn(unsigned interface, std::int64_t now_ns) const noexcept {
  return std::ranges::any_of(heard_, [&](const Heard& heard) {
    return heard.interface.load(std::memory_order_relaxed) == interface &&
           now_ns - heard.any_ns.load(std::memory_order_relaxed) < kHeardNs;
  });
}

ssize_t DomainNetworks::Send(int socket, const msghdr& packet, int flags) {
  sockaddr_in to{};
  if (packet.msg_name == nullptr || packet.msg_namelen < sizeof to) {
    return sendmsg(socket, &packet, flags);
  }
  std::memcpy(&to, packet.msg_name, sizeof to);
  if (IsCut(MonotonicNowNs())) return static_cast<ssize_t>(SizeOf(packet));
  const std::uint32_t address = to.sin_addr.s_addr;
  if (IsMulticastAddress(address)) {
    return SendToGroup(socket, packet, flags, ntohs(to.sin_port));
  }
  if (reach_ != Reach::kInterface || IsLoopbackAddress(address) || CurrentNetworks().Has(address)) {
    return sendmsg(socket, &packet, flags);
  }
  for (const NetworkTable::Row& row : CurrentNetworks().used()) {
    if (Uses(row)) return SendBy(&row, socket, packet, flags);
  }
  return -1;
}

ssize_t DomainNetworks::SendToGroup(int socket, const msghdr& packet, int flags,
                                    std::uint16_t port) {
  const std::int64_t now_ns = MonotonicNowNs();
  const NetworkTable& table = CurrentNetworks();
  bool sent = false;
  for (std::size_t i = 0; i < table.count; ++i) {
    const NetworkTable::Row& row = table.rows[i];
    // an interface with several addresses carries a packet once
    const auto before = table.used().first(i);
    const bool repeated = std::ranges::any_of(before, [&](const NetworkTable::Row& other) {
      return other.interface == row.interface;
    });
    const bool for_all = port == discovery_port_.load();
    if (repeated || !Uses(row) || (!for_all && !WasHeardOn(row.interface, now_ns))) continue;
    sent = SendBy(&row, socket, packet, flags) >= 0 || sent;
  }
  return sent ? static_cast<ssize_t>(SizeOf(packet)) : -1;
}

ssize_t DomainNetworks::SendBy(const NetworkTable::Row* row, int socket, const msghdr& packet,
                               int flags) const {
  in_pktinfo way{};
  way.ipi_ifindex = static_cast<int>(row->interface);
  way.ipi_spec_dst.s_addr = row->address;
  alignas(cmsghdr) std::array<std::byte, CMSG_SPACE(sizeof way)> control{};
  msghdr copy = packet;
  copy.msg_control = control.data();
  copy.msg_controllen = control.size();
  cmsghdr* const head = CMSG_FIRSTHDR(&copy);
  head->cmsg_level = IPPROTO_IP;
  head->cmsg_type = IP_PKTINFO;
  head->cmsg_len = CMSG_LEN(sizeof way);
  std::memcpy(CMSG_DATA(head), &way, sizeof way);
  return sendmsg(socket, &copy, flags);
}

void DomainNetworks::SetMet(std::vector<ProgramId> programs) {
  if (!sources_) return;
  const std::scoped_lock lock(sources_mutex_);
  sources_->SetMet(programs);
}

bool DomainNetworks::Lets(std::span<const std::uint8_t> program,
                          const std::optional<AnnouncedSource>& source,
                          std::int64_t now_ns) noexcept {
  if (!sources_) return true;
  const std::scoped_lock lock(sources_mutex_);
  if (!source) return sources_->Lets(program, now_ns);
  bool new_turn = false;
  const bool lets = sources_->LetsAnnounce(program, *source, now_ns, new_turn);
  // the other side is to forget this one too, or it would not prove itself again
  if (new_turn && sources_->IsAlone()) Cut(now_ns + AnnouncedSources::kSilenceNs);
  return lets;
}

bool DomainNetworks::OnChange(const NetworkTable& before, const NetworkTable& now,
                              std::int64_t now_ns) {
  {
    const std::scoped_lock lock(mutex_);
    for (const Membership& membership : memberships_) JoinAll(membership, now);
  }
  return std::ranges::any_of(before.used(), [&](const NetworkTable::Row& gone) {
    const bool stays = std::ranges::any_of(now.used(), [&](const NetworkTable::Row& row) {
      return row.address == gone.address && row.interface == gone.interface;
    });
    if (stays) return false;
    return std::ranges::any_of(heard_, [&](const Heard& heard) {
      return heard.address.load() == gone.address && now_ns - heard.unicast_ns.load() < kInUseNs;
    });
  });
}

}  // namespace tandem
