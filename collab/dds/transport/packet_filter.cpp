#include "collab/dds/transport/packet_filter.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <mutex>
#include <random>

#include <dds/ddsrt/sockets.h>
#include <dlfcn.h>
#include <netinet/in.h>

#include "collab/dds/transport/announcements.h"
#include "collab/dds/transport/fast_reader.h"
#include "engine/base/units.h"

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

PacketFilter::Sender* PacketFilter::SenderOf(std::span<const std::uint8_t> id,
                                             std::uint32_t address, std::int64_t now_ns) noexcept {
  std::uint64_t hash = seed_ ^ address;
  for (const std::uint8_t byte : id) hash = (hash ^ byte) * 0x9E3779B97F4A7C15U;
  const std::span<Sender> set(&senders_[((hash >> 40U) % kSets) * kWays], kWays);
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

PacketDrop JudgeShared(const msghdr& message, std::size_t size) noexcept {
  // Cyclone wakes its own threads with one byte
  if (size <= 1) return PacketDrop::kNone;
  if (message.msg_iovlen != 1 || message.msg_name == nullptr) return PacketDrop::kNone;
  sockaddr_in from{};
  if (message.msg_namelen < sizeof from) return PacketDrop::kNone;
  std::memcpy(&from, message.msg_name, sizeof from);
  if (from.sin_family != AF_INET) return PacketDrop::kNone;
  const std::span<const std::uint8_t> packet(
      static_cast<const std::uint8_t*>(message.msg_iov[0].iov_base),
      std::min(size, message.msg_iov[0].iov_len));
  SharedFilter& shared = Shared();
  PacketDrop drop{};
  {
    const std::scoped_lock lock(shared.mutex);
    drop = shared.filter.Judge(packet, from.sin_addr.s_addr, MonotonicNow_ns());
  }
  shared.judged[static_cast<std::size_t>(drop)].fetch_add(1, std::memory_order_relaxed);
  return drop;
}

}  // namespace

PacketCounts PacketsJudged() noexcept {
  PacketCounts judged{};
  for (std::size_t i = 0; i < judged.size(); ++i) {
    judged[i] = Shared().judged[i].load(std::memory_order_relaxed);
  }
  return judged;
}

}  // namespace tandem

extern "C" {
// Replaces Cyclone's function, because Cyclone finds this one before its own. For a dropped packet
// it returns that nobody is there, as after an ICMP message. Cyclone passes over that code without
// a line in its log.
dds_return_t ddsrt_recvmsg(ddsrt_socket_t socket, ddsrt_msghdr_t* message, int flags,
                           ssize_t* received) {
  static const auto cyclones =
      reinterpret_cast<decltype(&ddsrt_recvmsg)>(dlsym(RTLD_NEXT, "ddsrt_recvmsg"));
  const dds_return_t code = cyclones(socket, message, flags, received);
  if (code == DDS_RETCODE_OK && *received > 0 &&
      tandem::JudgeShared(*message, static_cast<std::size_t>(*received)) !=
          tandem::PacketDrop::kNone) {
    *received = 0;
    return DDS_RETCODE_NO_CONNECTION;
  }
  return code;
}
}
