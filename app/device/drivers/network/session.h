#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "app/device/drivers/network/address.h"
#include "app/device/drivers/network/key.h"
#include "app/device/drivers/network/packet.h"

namespace tandem::driver::network {

/// Tandem's end of a link with one device: decides which packets are sound, new and from the
/// device, and which get an answer. It has no socket and no clock.
///
/// A device calls with a session number of its own in a hello. The welcome names a session number
/// of Tandem's that only Tandem can make, a code over the device's number and the count of
/// sessions. The first state that names both begins the session. So a replayed hello begins
/// nothing, and states of an earlier session or run name void numbers. Until that state, a caller
/// uses only one of a few offers.
class Session {
 public:
  struct Rules {
    std::int64_t stale_ns = 100'000'000;  // age from which a state is not used and a device is gone
    std::int64_t expiry_ns = 20'000'000;  // age from which a force is void
  };
  enum class Refusal {
    kNone,
    kForm,      // wrong length, or not a packet of this protocol
    kVersion,   // another version of the protocol
    kForged,    // wrong code
    kReplayed,  // not newer than the packets before
    kLate,      // follows from a packet that is too old
    kAddress,   // other address, without a code
    kSession,   // no session that is on
    kBusy,      // second device
    kOther,     // device with capabilities other than those of the first
    kUnsound    // values out of range
  };
  static constexpr std::size_t kRefusals = 11;

  /// `key`: empty: no codes. `secret`: makes session numbers.
  Session(Key key, Key secret, const Rules& rules);

  /// The result of a packet.
  struct Taken {
    Refusal refusal = Refusal::kNone;
    bool state = false;                  // true: there is a new state()
    std::optional<PacketWriter> answer;  // answer to the packet's sender
  };
  Taken Take(std::span<const std::uint8_t> bytes, const Address& from, std::int64_t now_ns);

  /// Returns whether the device is there: a state came and is not old.
  bool alive(std::int64_t now_ns) const { return on_ && now_ns - state_ns_ <= rules_.stale_ns; }
  /// Returns whether a session has begun and the device has not said goodbye.
  bool on() const { return on_; }
  bool ended() const { return ended_; }
  const State& state() const { return state_; }
  std::int64_t sent_ns() const { return header_.time_ns; }  // newest state, device's clock
  std::int64_t state_ns() const { return state_ns_; }       // its arrival
  std::int64_t echo_ns() const { return header_.echo_ns; }  // Tandem's packet that it follows from
  const Address& address() const { return address_; }
  const Hello& hello() const { return known_; }
  std::uint64_t sessions() const { return sessions_; }

  /// Makes the next force packet. `based_on_ns`: the sending time of the state that it follows
  /// from, by the device's clock.
  PacketWriter ForcePacket(const Force& force, std::int64_t based_on_ns, std::int64_t now_ns);
  PacketWriter EndPacket(std::int64_t now_ns);

  std::uint64_t refused(Refusal why) const { return refused_[static_cast<std::size_t>(why)]; }
  /// Says in half a line how many packets were refused, and what to do about most of them; empty:
  /// none.
  std::string Refusals() const;

 private:
  struct Offer {
    std::uint64_t device_session = 0;
    Hello hello;
  };
  Refusal Judge(std::span<const std::uint8_t> bytes, const Address& from, std::int64_t now_ns,
                Taken& taken);
  Refusal TakeHello(const Header& header, const Hello& hello, std::int64_t now_ns, Taken& taken);
  Refusal Begin(const Header& header, const Address& from, std::int64_t now_ns);
  std::uint64_t NumberFor(std::uint64_t device_session) const;
  void Seal(PacketWriter& packet) const;

  Key key_;
  Key secret_;
  Rules rules_;
  std::array<Offer, 8> offers_{};  // callers that have not begun; the oldest is overwritten
  std::size_t next_offer_ = 0;
  std::uint64_t sessions_ = 0;
  Hello known_;
  bool on_ = false;
  bool ended_ = false;
  Header header_;  // newest header of the device in this session
  Address address_;
  State state_;
  std::int64_t state_ns_ = 0;
  std::uint64_t sent_ = 0;
  std::array<std::uint64_t, kRefusals> refused_{};
};

}  // namespace tandem::driver::network
