#include "collab/dds/transport/packet_filter.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <mutex>
#include <random>

#include <netinet/in.h>

#include "collab/dds/networks/domain_networks.h"
#include "collab/dds/networks/usable_networks.h"
#include "collab/dds/transport/announcements.h"
#include "engine/base/units.h"
#include "engine/realtime/clock.h"

namespace tandem {
namespace {

constexpr std::size_t kHeaderBytes = 20;
constexpr std::size_t kIdAt = 8;  // place of the program's id, after the protocol's mark, version
                                  // and vendor
constexpr std::size_t kIdBytes = 12;

}  // namespace

const char* NameOf(PacketDrop reason) noexcept {
  switch (reason) {
    case PacketDrop::kNone:
      return "passed";
    case PacketDrop::kNotRtps:
      return "not_rtps";
    case PacketDrop::kNewSender:
      return "new_sender";
    case PacketDrop::kForged:
      return "forged";
    case PacketDrop::kEndpoints:
      return "endpoints";
    case PacketDrop::kFlood:
      return "flood";
    case PacketDrop::kNetwork:
      return "network";
    case PacketDrop::kSource:
      return "source";
    case PacketDrop::kCount:
      break;
  }
  return "";
}

PacketFilter::PacketFilter(std::uint64_t seed) : seed_(seed | 1U), senders_(kSets * kWays) {}

bool PacketFilter::Pace::Lets(std::int64_t now_ns, std::int64_t per_second,
                              std::int64_t at_once) noexcept {
  const std::int64_t interval_ns = kSecondNs / per_second;
  paid_ns = std::max(paid_ns, now_ns);
  if (paid_ns - now_ns > at_once * interval_ns) return false;
  paid_ns += interval_ns;
  return true;
}

PacketDrop PacketFilter::Judge(std::span<const std::uint8_t> packet, std::uint32_t address,
                               std::int64_t now_ns) noexcept {
  if (packet.size() < kHeaderBytes || std::memcmp(packet.data(), "RTPS", 4) != 0) {
    return PacketDrop::kNotRtps;
  }
  const AnnouncedIn announced = WhatIsAnnounced(packet);
  if (announced.unsound || announced.lease_s > kLongestLease) return PacketDrop::kForged;
  Sender* const sender = SenderOf(packet.subspan(kIdAt, kIdBytes), address, now_ns);
  if (sender == nullptr) return PacketDrop::kNewSender;
  sender->received_ns = now_ns;
  if (!sender->packets.Lets(now_ns, kPacketsPerSecond, 2 * kPacketsPerSecond)) {
    return PacketDrop::kFlood;
  }
  for (int i = 0; i < announced.endpoints; ++i) {
    if (!sender->endpoints.Lets(now_ns, kEndpointsPerSecond, kEndpointsAtOnce) ||
        !endpoints_.Lets(now_ns, 4 * kEndpointsPerSecond, kAllEndpointsAtOnce)) {
      return PacketDrop::kEndpoints;
    }
  }
  return PacketDrop::kNone;
}

bool PacketFilter::IsHere(const Sender& sender, std::int64_t now_ns) noexcept {
  return sender.received_ns != 0 && now_ns - sender.received_ns < kForgetNs;
}

int PacketFilter::SendersOf(std::uint32_t address, std::int64_t now_ns) const noexcept {
  return static_cast<int>(std::ranges::count_if(senders_, [&](const Sender& one) {
    return one.address == address && IsHere(one, now_ns);
  }));
}

std::size_t PacketFilter::SetOf(std::span<const std::uint8_t> id,
                                std::uint32_t address) const noexcept {
  std::uint64_t hash = seed_ ^ address;
  for (const std::uint8_t byte : id) hash = (hash ^ byte) * 0x9E3779B97F4A7C15U;
  return ((hash >> 40U) % kSets) * kWays;
}

bool PacketFilter::Knows(std::span<const std::uint8_t> packet, std::uint32_t address,
                         std::int64_t now_ns) const noexcept {
  if (packet.size() < kHeaderBytes) return false;
  const std::span<const std::uint8_t> id = packet.subspan(kIdAt, kIdBytes);
  return std::ranges::any_of(
      std::span(&senders_[SetOf(id, address)], kWays), [&](const Sender& one) {
        return IsHere(one, now_ns) && one.address == address && std::ranges::equal(one.id, id);
      });
}

PacketFilter::Sender* PacketFilter::SenderOf(std::span<const std::uint8_t> id,
                                             std::uint32_t address, std::int64_t now_ns) noexcept {
  const std::span<Sender> set(&senders_[SetOf(id, address)], kWays);
  Sender* place = nullptr;
  for (Sender& one : set) {
    if (!IsHere(one, now_ns)) {
      place = place == nullptr ? &one : place;
    } else if (one.address == address && std::ranges::equal(one.id, id)) {
      return &one;
    }
  }
  if (!PaceOf(address, now_ns).Lets(now_ns, kNewPerSecond, kNewAtOnce)) return nullptr;
  const int own = SendersOf(address, now_ns);
  if (own >= kOfAddress) return nullptr;
  if (place == nullptr) {
    int most = own + 1;  // so that the new sender is not the next to give way
    for (Sender& one : set) {
      const int of_one = SendersOf(one.address, now_ns);
      if (of_one <= most) continue;
      most = of_one;
      place = &one;
    }
    if (place == nullptr) return nullptr;
  }
  *place = Sender{};
  place->address = address;
  place->received_ns = now_ns;
  std::ranges::copy(id, place->id.begin());
  return place;
}

PacketFilter::Pace& PacketFilter::PaceOf(std::uint32_t address, std::int64_t now_ns) noexcept {
  // a pace that is paid off is equal to a new one
  Address* free = nullptr;
  for (Address& one : addresses_) {
    if (one.requested_ns != 0 && one.address == address) {
      one.requested_ns = now_ns;
      return one.pace;
    }
    if (free == nullptr && (one.requested_ns == 0 || one.pace.paid_ns <= now_ns)) free = &one;
  }
  if (free == nullptr) return others_;
  *free = Address{};
  free->address = address;
  free->requested_ns = now_ns;
  return free->pace;
}

namespace {

// The filter of this process, shared by Cyclone's receive threads.
struct SharedFilter {
  std::mutex mutex;
  PacketFilter filter{std::random_device{}() | std::uint64_t{std::random_device{}()} << 32U};
  std::array<std::atomic<std::uint64_t>, static_cast<std::size_t>(PacketDrop::kCount)> judged{};
};

// never destroyed, because Cyclone's threads may outlive main()
SharedFilter& Shared() {
  static auto& shared = *new SharedFilter;
  return shared;
}

// Returns the way a packet came, from what the kernel says beside it.
Arrival ArrivalOf(const msghdr& message, std::uint32_t from) noexcept {
  Arrival arrival{.from = from};
  msghdr readable = message;  // the macros want no const
  for (cmsghdr* one = CMSG_FIRSTHDR(&readable); one != nullptr; one = CMSG_NXTHDR(&readable, one)) {
    if (one->cmsg_level != IPPROTO_IP || one->cmsg_type != IP_PKTINFO) continue;
    in_pktinfo way{};
    std::memcpy(&way, CMSG_DATA(one), sizeof way);
    arrival.at = way.ipi_spec_dst.s_addr;
    arrival.interface = static_cast<unsigned>(way.ipi_ifindex);
    arrival.to_group = IsMulticastAddress(way.ipi_addr.s_addr);
  }
  return arrival;
}

// Returns the address at which the sender is answered. Programs of this machine reach one another
// whatever becomes of its networks.
std::uint32_t WayTo(std::uint32_t from) {
  const bool is_here = IsLoopbackAddress(from) || CurrentNetworks().Has(from);
  return is_here ? htonl(INADDR_LOOPBACK) : from;
}

// Returns where a packet announces its program from; nothing: it announces none.
std::optional<AnnouncedSource> SourceOf(std::span<const std::uint8_t> packet, std::uint32_t from) {
  const AnnouncedIn announced = WhatIsAnnounced(packet);
  if (!announced.program) return std::nullopt;
  // an announcement that was altered is another source, whatever address it claims to come from
  return AnnouncedSource{.way = announced.content * 31 + WayTo(from), .lease_s = announced.lease_s};
}

// Others are answered at the address that their announcements come from. The address that they
// announce may be of a network that does not lead here, or may have changed.
void CorrectAnnouncedAddress(std::span<std::uint8_t> packet, std::uint32_t from,
                             const PacketFilter& filter, std::int64_t now_ns) {
  struct Known {
    std::span<const std::uint8_t> packet;
    std::uint32_t from;
    const PacketFilter& filter;
    std::int64_t now_ns;
  };
  const Known known{packet, from, filter, now_ns};
  // one reference: the function needs no memory
  ReplaceAnnouncedAddresses(packet, WayTo(from), [&known](std::uint32_t announced) {
    // a router that translates addresses may send from others than it is reached at
    return !IsPublicAddress(announced) || !IsPublicAddress(known.from) ||
           known.filter.Knows(known.packet, announced, known.now_ns);
  });
}

}  // namespace

PacketDrop JudgeArrival(const msghdr& message, std::size_t size,
                        DomainNetworks* networks) noexcept {
  // Cyclone wakes its own threads with one byte
  if (size <= 1) return PacketDrop::kNone;
  if (message.msg_iovlen != 1 || message.msg_name == nullptr) return PacketDrop::kNone;
  sockaddr_in from{};
  if (message.msg_namelen < sizeof from) return PacketDrop::kNone;
  std::memcpy(&from, message.msg_name, sizeof from);
  if (from.sin_family != AF_INET) return PacketDrop::kNone;
  const std::span<std::uint8_t> packet(static_cast<std::uint8_t*>(message.msg_iov[0].iov_base),
                                       std::min(size, message.msg_iov[0].iov_len));
  SharedFilter& shared = Shared();
  const Arrival arrival = ArrivalOf(message, from.sin_addr.s_addr);
  const std::int64_t now_ns = MonotonicNowNs();
  PacketDrop drop = PacketDrop::kNetwork;
  if (networks == nullptr || (networks->Hears(arrival) && !networks->IsCut(now_ns))) {
    const std::scoped_lock lock(shared.mutex);
    drop = shared.filter.Judge(packet, arrival.from, now_ns);
    if (drop == PacketDrop::kNone && networks != nullptr && networks->proves_members() &&
        !networks->Lets(packet.subspan(kIdAt, kIdBytes), SourceOf(packet, arrival.from), now_ns)) {
      drop = PacketDrop::kSource;
    }
    if (drop == PacketDrop::kNone && networks != nullptr) {
      networks->Note(arrival, now_ns);
      CorrectAnnouncedAddress(packet, arrival.from, shared.filter, now_ns);
    }
  }
  shared.judged[static_cast<std::size_t>(drop)].fetch_add(1, std::memory_order_relaxed);
  return drop;
}

PacketCounts PacketsJudged() noexcept {
  PacketCounts judged{};
  for (std::size_t i = 0; i < judged.size(); ++i) {
    judged[i] = Shared().judged[i].load(std::memory_order_relaxed);
  }
  return judged;
}

}  // namespace tandem
