#include "app/device/drivers/network/session.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace tandem::driver::network {

Session::Session(Key key, Key secret, const Rules& rules)
    : key_(std::move(key)), secret_(std::move(secret)), rules_(rules) {}

Session::Taken Session::Take(std::span<const std::uint8_t> bytes, const Address& from,
                             std::int64_t now_ns) {
  Taken taken;
  taken.refusal = Judge(bytes, from, now_ns, taken);
  if (taken.refusal != Refusal::kNone) ++refused_[static_cast<std::size_t>(taken.refusal)];
  return taken;
}

Session::Refusal Session::Judge(std::span<const std::uint8_t> bytes, const Address& from,
                                std::int64_t now_ns, Taken& taken) {
  Header header;
  const bool keyed = !key_.empty();
  const Form form = ReadHeader(bytes, keyed, header);
  if (form == Form::kVersion) return Refusal::kVersion;
  if (form != Form::kSound) return Refusal::kForm;
  if (keyed && !key_.Holds(bytes.first(bytes.size() - kCodeBytes), bytes.last(kCodeBytes))) {
    return Refusal::kForged;
  }
  const bool of_session = on_ && header.device_session == header_.device_session &&
                          header.host_session == header_.host_session;
  if (header.kind == Kind::kHello) return TakeHello(header, ReadHello(bytes), now_ns, taken);
  if (header.kind != Kind::kState && header.kind != Kind::kDeviceEnds) return Refusal::kForm;

  // the state follows from a packet of Tandem's, so its echo is not in the future
  if (header.echo_ns <= 0 || header.echo_ns > now_ns) return Refusal::kUnsound;
  if (!of_session) {
    if (header.kind != Kind::kState) return Refusal::kSession;
    const Refusal begun = Begin(header, from, now_ns);
    if (begun != Refusal::kNone) return begun;
  } else {
    // a code proves the sender at any address; without a code the address must match
    if (!keyed && !(from == address_)) return Refusal::kAddress;
    if (header.sequence <= header_.sequence) return Refusal::kReplayed;
    if (now_ns - header.echo_ns > rules_.stale_ns) return Refusal::kLate;
  }
  if (header.kind == Kind::kDeviceEnds) {
    on_ = false;
    ended_ = true;
    return Refusal::kNone;
  }
  const State state = ReadState(bytes);
  address_ = from;
  if (!IsSound(state)) {
    header_.sequence = header.sequence;
    return Refusal::kUnsound;
  }
  header_ = header;
  state_ = state;
  state_ns_ = now_ns;
  taken.state = true;
  return Refusal::kNone;
}

Session::Refusal Session::TakeHello(const Header& header, const Hello& hello, std::int64_t now_ns,
                                    Taken& taken) {
  if (!IsSound(hello) || header.device_session == 0) return Refusal::kUnsound;
  if (alive(now_ns)) {
    // a hello of the same device that was delayed
    return header.device_session == header_.device_session ? Refusal::kReplayed : Refusal::kBusy;
  }
  if (sessions_ > 0 && !(hello == known_)) return Refusal::kOther;
  const auto known = std::ranges::find(offers_, header.device_session, &Offer::device_session);
  if (known == offers_.end()) {
    offers_[next_offer_] = {header.device_session, hello};
    next_offer_ = (next_offer_ + 1) % offers_.size();
  } else if (!(known->hello == hello)) {
    return Refusal::kOther;
  }
  Header welcome;
  welcome.kind = Kind::kWelcome;
  welcome.device_session = header.device_session;
  welcome.host_session = NumberFor(header.device_session);
  welcome.time_ns = now_ns;
  welcome.echo_ns = header.time_ns;
  Seal(taken.answer.emplace(welcome, !key_.empty()));
  return Refusal::kNone;
}

Session::Refusal Session::Begin(const Header& header, const Address& from, std::int64_t now_ns) {
  if (header.device_session == 0 || header.host_session != NumberFor(header.device_session)) {
    return Refusal::kSession;
  }
  if (alive(now_ns)) return Refusal::kBusy;
  if (now_ns - header.echo_ns > rules_.stale_ns) return Refusal::kLate;
  const auto offer = std::ranges::find(offers_, header.device_session, &Offer::device_session);
  if (offer == offers_.end()) return Refusal::kSession;
  known_ = offer->hello;
  header_ = {};
  header_.device_session = header.device_session;
  header_.host_session = header.host_session;
  address_ = from;
  on_ = true;
  ended_ = false;
  sent_ = 0;
  ++sessions_;  // makes the numbers offered so far void
  offers_.fill({});
  return Refusal::kNone;
}

std::uint64_t Session::NumberFor(std::uint64_t device_session) const {
  std::array<std::uint8_t, 16> text{};
  std::memcpy(text.data(), &device_session, sizeof device_session);
  std::memcpy(text.data() + 8, &sessions_, sizeof sessions_);
  const Key::Code code = secret_.CodeOf(text);
  std::uint64_t number = 0;
  std::memcpy(&number, code.data(), sizeof number);
  return number | 1U;  // never 0
}

void Session::Seal(PacketWriter& packet) const {
  if (!key_.empty()) std::ranges::copy(key_.CodeOf(packet.text()), packet.code().begin());
}

PacketWriter Session::ForcePacket(const Force& force, std::int64_t based_on_ns,
                                  std::int64_t now_ns) {
  Header header = header_;
  header.kind = Kind::kForce;
  header.sequence = ++sent_;
  header.time_ns = now_ns;
  header.echo_ns = based_on_ns;
  PacketWriter packet(header, !key_.empty());
  Force timed = force;
  timed.expiry_us = static_cast<std::uint32_t>(rules_.expiry_ns / 1000);
  packet.Put(timed);
  Seal(packet);
  return packet;
}

PacketWriter Session::EndPacket(std::int64_t now_ns) {
  Header header = header_;
  header.kind = Kind::kHostEnds;
  header.sequence = ++sent_;
  header.echo_ns = header_.time_ns;
  header.time_ns = now_ns;
  PacketWriter packet(header, !key_.empty());
  Seal(packet);
  return packet;
}

std::string Session::Refusals() const {
  static constexpr std::array<const char*, kRefusals> kWords{
      "",
      "are not packets of this protocol: see docs/devices.md",
      "are of another version of this protocol: update the older end",
      "have a wrong code: give both ends the same key",
      "came twice or in a wrong order",
      "came too late: the network is slow, so raise stale_ms",
      "came from another address, without a key",
      "belong to no session",
      "came from a second device: end one of them",
      "came from a device with other capabilities than the first one: open the device again",
      "have numbers out of range"};
  std::uint64_t all = 0;
  for (const std::uint64_t count : refused_) all += count;
  if (all == 0) return {};
  const auto most = std::ranges::max_element(refused_);
  return std::to_string(all) + " packets were refused, of which " + std::to_string(*most) + " " +
         kWords[static_cast<std::size_t>(most - refused_.begin())];
}

}  // namespace tandem::driver::network
