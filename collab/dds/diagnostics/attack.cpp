#include "collab/dds/diagnostics/attack.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include "collab/dds/cyclone/cyclone_log.h"
#include "collab/dds/cyclone/partitions.h"
#include "collab/dds/cyclone/qos.h"
#include "collab/dds/transport/domain.h"
#include "collab/dds/wire/wire.h"
#include "engine/base/units.h"
#include "engine/realtime/clock.h"

namespace tandem {
namespace {

constexpr std::int64_t kBeatEveryNs = 200'000'000;

struct NameOfAttack {
  Attack attack;
  const char* name;
};
constexpr std::array<NameOfAttack, static_cast<std::size_t>(Attack::kCount)> kNames{
    {{Attack::kStates, "states"},
     {Attack::kKeys, "keys"},
     {Attack::kNames, "names"},
     {Attack::kPackets, "packets"}}};

/// A program with writers in its own partition and no reader.
class Flooder {
 public:
  explicit Flooder(const DdsOptions& options) : peer_(options.peer) {}

  std::optional<Error> Open(const DdsOptions& options) {
    RedirectCycloneLog();
    Result<Entity> domain = CreateDomain(options);
    if (!domain) return domain.error();
    domain_ = *std::move(domain);
    participant_ = Entity(dds_create_participant(options.domain, nullptr, nullptr));
    const std::string partition = PeerPartition(peer_);
    states_ = Writer(tandem_ObjectState_desc, "state/1", Purpose::kMotion, partition);
    infos_ = Writer(tandem_PeerInfo_desc, "peer_info", Purpose::kPresence, partition);
    if (states_ <= 0 || infos_ <= 0) return Error{"no writer to flood with"};
    return std::nullopt;
  }

  bool State(ObjectId object) {
    ObjectState state;
    state.peer = peer_;
    state.object = object;
    state.epoch = 1;
    state.seq = ++seq_;
    state.sample_ns = MonotonicNowNs();
    tandem_ObjectState wire;
    ToWire(state, wire);
    return dds_write(states_, &wire) == DDS_RETCODE_OK;
  }
  bool Presence(const std::string& name) {
    PeerInfo info;
    info.peer = peer_;
    info.beat = ++beat_;
    info.role = Role::kActive;
    info.name = name;
    tandem_PeerInfo wire{};
    InfoBuffers room;
    return ToWire(info, wire, room) && dds_write(infos_, &wire) == DDS_RETCODE_OK;
  }

 private:
  dds_entity_t Writer(const dds_topic_descriptor_t& type, const char* topic, Purpose purpose,
                      const std::string& partition) const {
    const Qos qos = MakeQos(purpose, partition);
    const dds_entity_t made = dds_create_topic(participant_.get(), &type, topic, nullptr, nullptr);
    return dds_create_writer(participant_.get(), made, qos.get(), nullptr);
  }

  const PeerId peer_;
  Entity domain_;
  Entity participant_;
  dds_entity_t states_ = 0;
  dds_entity_t infos_ = 0;
  std::uint32_t seq_ = 0;
  std::uint32_t beat_ = 0;
};

class Bytes {
 public:
  Bytes& Number(std::uint64_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) bytes_ += static_cast<char>(value >> (8 * i));
    return *this;
  }
  Bytes& Text(std::string_view text) {
    bytes_ += text;
    return *this;
  }
  Bytes& Parameter(std::uint16_t id, const Bytes& value) {
    std::string padded = value.bytes_;
    padded.resize((padded.size() + 3) / 4 * 4, '\0');
    return Number(id, 2).Number(padded.size(), 2).Text(padded);
  }
  const std::string& get() const { return bytes_; }

 private:
  std::string bytes_;
};

/// Returns a forged announcement of a program of the session (RTPS 2.5, section 8.5.3.2). It has
/// every field without which Cyclone would not take it for one.
std::string ForgedAnnouncement(std::uint64_t program, const std::string& tag) {
  const Bytes id = Bytes().Number(program, 8).Number(0x01020304, 4);
  const Bytes guid = Bytes().Text(id.get()).Number(0xC1010000, 4);
  const Bytes address = Bytes()
                            .Number(1, 4)  // IPv4 over UDP
                            .Number(9, 4)  // nobody listens there
                            .Text(std::string(12, '\0'))
                            .Number(0x0100007F, 4);
  Bytes list;
  list.Number(0x0300, 2).Number(0, 2);
  list.Parameter(0x0015, Bytes().Number(0x0502, 2).Number(0, 2));
  list.Parameter(0x0016, Bytes().Number(0x1001, 2).Number(0, 2));
  list.Parameter(0x0050, guid);
  list.Parameter(0x0032, address).Parameter(0x0031, address);
  list.Parameter(0x0058, Bytes().Number(0xC3F, 4));
  list.Parameter(0x0002, Bytes().Number(10, 4).Number(0, 4));
  list.Parameter(0x4014, Bytes().Number(tag.size() + 1, 4).Text(tag).Number(0, 1));
  list.Number(1, 2).Number(0, 2);
  Bytes data;
  data.Number(0, 2).Number(16, 2).Number(0xC7000100, 4).Number(0xC2000100, 4);
  data.Number(0, 4).Number(1, 4).Text(list.get());
  return Bytes()
      .Text("RTPS")
      .Number(0x10010502, 4)
      .Text(id.get())
      .Number(0x0515, 2)
      .Number(data.get().size(), 2)
      .Text(data.get())
      .get();
}

/// Paces a flood by its plan.
class FloodPace {
 public:
  explicit FloodPace(const FloodPlan& plan) : plan_(plan), begin_ns_(MonotonicNowNs()) {}

  /// Returns false when all that the plan asks for has been sent. Waits where the flood is ahead of
  /// its plan.
  bool GoesOn(std::uint64_t sent) const {
    for (;;) {
      const std::int64_t now_ns = MonotonicNowNs();
      const double gone_s = ToSeconds(now_ns - begin_ns_);
      if (gone_s >= plan_.seconds || (plan_.most > 0 && sent >= plan_.most)) return false;
      if (plan_.per_second <= 0 || static_cast<double>(sent) <= gone_s * plan_.per_second) {
        return true;
      }
      dds_sleepfor(DDS_USECS(50));
    }
  }

 private:
  const FloodPlan plan_;
  const std::int64_t begin_ns_;
};

/// A socket to a port on loopback. The kernel tells it whether a program listens there.
class PortSocket {
 public:
  explicit PortSocket(std::uint32_t port)
      : descriptor_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    to.sin_port = htons(static_cast<std::uint16_t>(port));
    connect(descriptor_, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  }
  ~PortSocket() { close(descriptor_); }
  PortSocket(const PortSocket&) = delete;
  PortSocket& operator=(const PortSocket&) = delete;

  bool HasListener() const {
    const char nothing = 0;
    for (int i = 0; i < 2; ++i) {  // the refusal of the first message comes with the second
      if (send(descriptor_, &nothing, 1, 0) < 0) return false;
    }
    return true;
  }
  /// Returns how many messages went out.
  std::uint64_t Send(std::span<mmsghdr> messages) const {
    const int sent =
        sendmmsg(descriptor_, messages.data(), static_cast<unsigned>(messages.size()), 0);
    return sent > 0 ? static_cast<std::uint64_t>(sent) : 0;
  }

 private:
  int descriptor_;
};

/// Announcements of new programs, many of them for one call of the kernel.
class ForgedBatch {
 public:
  static constexpr std::size_t kSize = 32;

  explicit ForgedBatch(const std::string& tag) {
    constexpr std::uint64_t kMark = 0xA5C3960FF0695A3CU;
    const std::string model = ForgedAnnouncement(kMark, tag);
    const std::string mark = Bytes().Number(kMark, 8).get();
    std::size_t at = model.find(mark);
    for (; at != std::string::npos; at = model.find(mark, at + 1)) places_.push_back(at);
    for (std::size_t i = 0; i < kSize; ++i) {
      packets_[i] = model;
      pieces_[i] = {packets_[i].data(), packets_[i].size()};
      messages_[i].msg_hdr.msg_iov = &pieces_[i];
      messages_[i].msg_hdr.msg_iovlen = 1;
    }
  }
  /// Returns messages that announce `count` programs from `first` on.
  std::span<mmsghdr> Of(std::uint64_t first, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint64_t program = first + i;
      for (const std::size_t at : places_) {
        std::memcpy(packets_[i].data() + at, &program, sizeof program);
      }
    }
    return std::span(messages_).first(count);
  }

 private:
  std::vector<std::size_t> places_;  // places of the program's number in a packet
  std::array<std::string, kSize> packets_;
  std::array<iovec, kSize> pieces_{};
  std::array<mmsghdr, kSize> messages_{};
};

Result<std::uint64_t> FloodPackets(const DdsOptions& options, const FloodPlan& plan) {
  std::vector<std::unique_ptr<PortSocket>> ports;
  for (std::uint32_t program = 0; program <= kLastProgramIndex; ++program) {
    auto port = std::make_unique<PortSocket>(DiscoveryPort(options.domain, program));
    if (port->HasListener()) ports.push_back(std::move(port));
  }
  if (ports.empty()) return Error{"no program of the domain is there to be flooded"};
  ForgedBatch batch(DiscoveryTag(options.session));
  const FloodPace pace(plan);
  std::uint64_t program = options.peer << 20U;
  std::uint64_t sent = 0;
  while (pace.GoesOn(sent)) {
    const std::uint64_t left = plan.most > 0 ? plan.most - sent : ForgedBatch::kSize;
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(left, ForgedBatch::kSize));
    for (const auto& port : ports) sent += port->Send(batch.Of(program, count));
    program += count;
  }
  return sent;
}

}  // namespace

const char* NameOf(Attack attack) noexcept {
  for (const NameOfAttack& one : kNames) {
    if (one.attack == attack) return one.name;
  }
  return "";
}

Result<Attack> AttackNamed(const std::string& name) {
  for (const NameOfAttack& one : kNames) {
    if (name == one.name) return one.attack;
  }
  return Error{"there is no attack '" + name + "'"};
}

Result<std::uint64_t> Flood(Attack attack, const DdsOptions& options, const FloodPlan& plan) {
  if (attack == Attack::kPackets) return FloodPackets(options, plan);
  Flooder flooder(options);
  if (const std::optional<Error> error = flooder.Open(options)) return *error;
  flooder.Presence("flood");
  const FloodPace pace(plan);
  std::uint64_t sent = 0;
  std::int64_t beat_ns = 0;
  for (; pace.GoesOn(sent); ++sent) {
    if (attack == Attack::kNames) {
      flooder.Presence("flood-" + std::to_string(sent));
      continue;
    }
    const std::int64_t now_ns = MonotonicNowNs();
    if (now_ns - beat_ns > kBeatEveryNs) {
      flooder.Presence("flood");
      beat_ns = now_ns;
    }
    flooder.State(attack == Attack::kKeys ? static_cast<ObjectId>(sent) : 0);
  }
  return sent;
}

}  // namespace tandem
