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

/// Tandem's end of a link with one device: what is sound, new and from the device, and what is to
/// be answered. It has no socket and no clock.
///
/// A device calls with a session number of its own in a hello. The welcome names a session number
/// of Tandem's, which only Tandem can make: it is a code over the device's number and over how many
/// sessions there were. The first state that names both begins the session. So a hello that is
/// played again begins nothing, and states of an earlier session, or of an earlier run, name
/// numbers that are of no use any more. Nothing is kept for a caller before that first state.
class Session {
 public:
  struct Rules {
    std::int64_t stale_ns = 100'000'000;  // age from which a state is of no use, and a device gone
    std::int64_t expiry_ns = 20'000'000;  // age from which a force is void
  };
  enum class Refusal {
    kNone,
    kForm,      // too short, too long, or no packet of this protocol
    kVersion,   // of another version of it
    kForged,    // the code is wrong
    kReplayed,  // not newer than what came before
    kLate,      // follows from a packet that is too old
    kAddress,   // from elsewhere, without a code
    kSession,   // of no session that is on
    kBusy,      // from a second device
    kOther,     // from a device that can other things than the one that was opened
    kUnsound    // its numbers are none
  };
  static constexpr std::size_t kRefusals = 11;

  /// `key`: empty, no codes. `secret`: makes session numbers.
  Session(Key key, Key secret, const Rules& rules);

  /// What a packet is good for.
  struct Taken {
    Refusal refusal = Refusal::kNone;
    bool state = false;                  // there is a new state()
    std::optional<PacketWriter> answer;  // goes to where the packet came from
  };
  Taken Take(std::span<const std::uint8_t> bytes, const Address& from, std::int64_t now_ns);

  /// The device is there: a state came, and is not old.
  bool alive(std::int64_t now_ns) const { return on_ && now_ns - state_ns_ <= rules_.stale_ns; }
  /// There was a device, and it has not said goodbye.
  bool on() const { return on_; }
  bool ended() const { return ended_; }
  const State& state() const { return state_; }
  std::int64_t sent_ns() const { return header_.time_ns; }  // newest state, by the device's clock
  std::int64_t state_ns() const { return state_ns_; }       // when it came
  std::int64_t echo_ns() const { return header_.echo_ns; }  // our packet that it follows from
  const Address& address() const { return address_; }
  const Hello& hello() const { return known_; }
  std::uint64_t sessions() const { return sessions_; }

  /// The next force packet to the device. `based_on_ns`: when the state was sent that it follows
  /// from, by the device's clock.
  PacketWriter ForcePacket(const Force& force, std::int64_t based_on_ns, std::int64_t now_ns);
  PacketWriter EndPacket(std::int64_t now_ns);

  std::uint64_t refused(Refusal why) const { return refused_[static_cast<std::size_t>(why)]; }
  /// Packets that were refused, and what to do about most of them, in half a line; empty: none.
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
  std::array<Offer, 8> offers_{};  // by callers that have not begun; the oldest is overwritten
  std::size_t next_offer_ = 0;
  std::uint64_t sessions_ = 0;
  Hello known_;
  bool on_ = false;
  bool ended_ = false;
  Header header_;  // newest of the device in this session
  Address address_;
  State state_;
  std::int64_t state_ns_ = 0;
  std::uint64_t sent_ = 0;
  std::array<std::uint64_t, kRefusals> refused_{};
};

}  // namespace tandem::driver::network
