#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <sys/socket.h>

namespace tandem {

class DomainNetworks;

/// The reason why a packet was dropped before DDS saw it.
enum class PacketDrop : std::uint8_t {
  kNone,
  kNotRtps,    // not a packet of DDS
  kNewSender,  // from an unknown program, and there are too many of those
  kForged,     // announces as no program of Tandem does, or asks to be remembered for long
  kEndpoints,  // announces more readers and writers than a program has
  kFlood,      // more packets than a program sends
  kNetwork,    // came by a network that the domain is not on
  kSource,     // its program is not met, and is announced otherwise too
  kCount
};
const char* NameOf(PacketDrop reason) noexcept;  // "not_rtps" …

/// Decides which packets DDS sees, because DDS keeps memory for every announced program, with keys
/// or without. A sender is a program's id together with the address of its packets. So a packet
/// with another program's id from elsewhere takes nothing from that program. New senders come at a
/// limited pace for each address, and silent senders are forgotten. A new sender without room
/// replaces a sender of the address that has the most. All memory is taken at construction. The
/// class reads no clock. Used by one thread at a time.
class PacketFilter {
 public:
  static constexpr std::size_t kSets = 256;
  static constexpr std::size_t kWays = 4;           // senders in a set
  static constexpr std::size_t kAddresses = 64;     // addresses with their own pace; all others
                                                    // share one
  static constexpr int kOfAddress = 128;            // senders at an address
  static constexpr std::int64_t kNewAtOnce = 128;   // new senders at an address
  static constexpr std::int64_t kNewPerSecond = 2;  // new senders beyond those
  static constexpr std::int64_t kPacketsPerSecond = 50'000;  // from a sender; twice as many at once
  static constexpr std::int64_t kEndpointsPerSecond = 20;    // announced by a sender
  static constexpr std::int64_t kEndpointsAtOnce = 512;
  static constexpr std::int64_t kAllEndpointsAtOnce = 2048;  // announced by all senders
  static constexpr std::int64_t kForgetNs = 20'000'000'000;
  static constexpr double kLongestLease = 60;  // s

  /// `seed` sets the order in which senders are kept, so that nobody can choose whom to displace.
  explicit PacketFilter(std::uint64_t seed);

  PacketDrop Judge(std::span<const std::uint8_t> packet, std::uint32_t address,
                   std::int64_t now_ns) noexcept;
  /// Returns whether the program in the packet's header was heard lately from that address.
  bool Knows(std::span<const std::uint8_t> packet, std::uint32_t address,
             std::int64_t now_ns) const noexcept;

 private:
  // Lets so many through at once, and further ones at a pace.
  struct Pace {
    std::int64_t paid_ns = 0;  // time at which all that was let through is paid off
    bool Lets(std::int64_t now_ns, std::int64_t per_second, std::int64_t at_once) noexcept;
  };
  struct Sender {
    std::array<std::uint8_t, 12> id{};
    std::uint32_t address = 0;
    std::int64_t received_ns = 0;  // 0: a free place
    Pace packets;
    Pace endpoints;
  };
  struct Address {
    std::uint32_t address = 0;
    std::int64_t requested_ns = 0;
    Pace pace;
  };

  Sender* SenderOf(std::span<const std::uint8_t> id, std::uint32_t address,
                   std::int64_t now_ns) noexcept;
  std::size_t SetOf(std::span<const std::uint8_t> id, std::uint32_t address) const noexcept;
  Pace& PaceOf(std::uint32_t address, std::int64_t now_ns) noexcept;
  static bool IsHere(const Sender& sender, std::int64_t now_ns) noexcept;
  int SendersOf(std::uint32_t address, std::int64_t now_ns) const noexcept;

  std::uint64_t seed_;
  std::vector<Sender> senders_;
  std::array<Address, kAddresses> addresses_{};
  Pace others_;
  Pace endpoints_;
};

/// Judges a packet that came by a socket of a domain, with this process's filter. `networks`: of
/// the domain; null: it is bound to none. Announcements that pass name the address that they came
/// from.
PacketDrop JudgeArrival(const msghdr& message, std::size_t size, DomainNetworks* networks) noexcept;

/// The packets of this process so far, by reason; kNone counts those that DDS saw.
using PacketCounts = std::array<std::uint64_t, static_cast<std::size_t>(PacketDrop::kCount)>;
PacketCounts PacketsJudged() noexcept;

}  // namespace tandem
