#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tandem {

/// Why a packet was dropped before DDS saw it.
enum class PacketDrop : std::uint8_t {
  kNone,
  kNotRtps,    // no packet of DDS
  kNewSender,  // of a program that was never heard, and there are too many of those
  kForged,     // announces as no program of ours does, or what is to be remembered for long
  kEndpoints,  // announces more readers and writers than a program has
  kFlood,      // more than a program sends
  kCount
};
const char* NameOf(PacketDrop reason) noexcept;  // "not_rtps" …

/// Decides which packets DDS gets to see, for DDS keeps memory for every program that is announced,
/// with keys or without. A sender is a program's id together with the address that its packets come
/// from: whoever uses another's id from elsewhere takes nothing from it. New senders come at a
/// limited pace for each address, and senders that fall silent are forgotten. Where there is no
/// room for a new one, one of the address with the most gives way. All memory is taken at
/// construction. Times are handed in. Used by one thread at a time.
class PacketFilter {
 public:
  static constexpr std::size_t kSets = 256;
  static constexpr std::size_t kWays = 4;           // senders of a set
  static constexpr std::size_t kAddresses = 64;     // whose pace is kept; the others share one
  static constexpr int kOfAddress = 128;            // senders of an address
  static constexpr std::int64_t kNewAtOnce = 128;   // of an address
  static constexpr std::int64_t kNewPerSecond = 2;  // and so many more
  static constexpr std::int64_t kPacketsPerSecond = 50'000;  // of a sender; twice as many at once
  static constexpr std::int64_t kEndpointsPerSecond = 20;    // announced by a sender
  static constexpr std::int64_t kEndpointsAtOnce = 512;
  static constexpr std::int64_t kAllEndpointsAtOnce = 2048;  // by all senders
  static constexpr std::int64_t kForgetNs = 20'000'000'000;
  static constexpr double kLongestLease = 60;  // s

  /// `seed`: of the order in which senders are kept, so that nobody can choose whom to displace.
  explicit PacketFilter(std::uint64_t seed);

  PacketDrop Judge(std::span<const std::uint8_t> packet, std::uint32_t address,
                   std::int64_t now_ns) noexcept;

 private:
  // Lets so many through at once, and then at a pace.
  struct Pace {
    std::int64_t paid_ns = 0;  // when all that was let through is paid off
    bool Lets(std::int64_t now_ns, std::int64_t per_second, std::int64_t at_once) noexcept;
  };
  struct Sender {
    std::array<std::uint8_t, 12> id{};
    std::uint32_t address = 0;
    std::int64_t heard_ns = 0;  // 0: a free place
    Pace packets;
    Pace endpoints;
  };
  struct Address {
    std::uint32_t address = 0;
    std::int64_t asked_ns = 0;
    Pace pace;
  };

  Sender* SenderOf(std::span<const std::uint8_t> id, std::uint32_t address,
                   std::int64_t now_ns) noexcept;
  Pace& PaceOf(std::uint32_t address, std::int64_t now_ns) noexcept;
  static bool IsHere(const Sender& sender, std::int64_t now_ns) noexcept;
  int SendersOf(std::uint32_t address, std::int64_t now_ns) const noexcept;

  std::uint64_t seed_;
  std::vector<Sender> senders_;
  std::array<Address, kAddresses> addresses_{};
  Pace others_;
  Pace endpoints_;
};

/// What this process has dropped so far, by reason; kNone: what DDS got to see.
using PacketCounts = std::array<std::uint64_t, static_cast<std::size_t>(PacketDrop::kCount)>;
PacketCounts PacketsJudged() noexcept;

}  // namespace tandem
