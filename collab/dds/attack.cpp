#include "collab/dds/attack.h"

#include <array>
#include <cstring>
#include <string_view>

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include "collab/dds/cyclone_log.h"
#include "collab/dds/domain.h"
#include "collab/dds/fast_reader.h"
#include "collab/dds/partitions.h"
#include "collab/dds/qos.h"
#include "collab/dds/wire.h"

namespace tandem {
namespace {

constexpr std::int64_t kBeatEveryNs = 200'000'000;
constexpr std::uint32_t kPrograms = 4;  // whose ports get packets

struct NameOfAttack {
  Attack attack;
  const char* name;
};
constexpr std::array<NameOfAttack, static_cast<std::size_t>(Attack::kCount)> kNames{
    {{Attack::kStates, "states"},
     {Attack::kKeys, "keys"},
     {Attack::kNames, "names"},
     {Attack::kPackets, "packets"}}};

/// A program with writers in its own partition, and no reader.
class Flooder {
 public:
  explicit Flooder(const DdsOptions& options) : peer_(options.peer) {}

  std::optional<Error> Open(const DdsOptions& options) {
    TakeOverCycloneLog();
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
    state.sample_ns = MonotonicNow_ns();
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
    InfoRoom room;
    return ToWire(info, wire, room) && dds_write(infos_, &wire) == DDS_RETCODE_OK;
  }

 private:
  dds_entity_t Writer(const dds_topic_descriptor_t& type, const char* topic, Purpose purpose,
                      const std::string& partition) const {
    const Qos qos = MakeQos(purpose, partition);
    const dds_entity_t made =
        dds_create_topic(participant_.get(), &type, topic, nullptr, nullptr);
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

/// How a program of the session announces itself (RTPS 2.5, section 8.5.3.2): every field that
/// Cyclone needs to take it for one.
std::string ForgedAnnouncement(std::uint64_t program, const std::string& tag) {
  const Bytes id = Bytes().Number(program, 8).Number(0x01020304, 4);
  const Bytes guid = Bytes().Text(id.get()).Number(0xC1010000, 4);
  const Bytes address = Bytes()
                            .Number(1, 4)     // IPv4 over UDP
                            .Number(9, 4)     // nobody listens there
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

std::uint64_t FloodPackets(const DdsOptions& options, std::int64_t until_ns) {
  const int out = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const std::string tag = DiscoveryTag(options.session);
  std::uint64_t sent = 0;
  while (MonotonicNow_ns() < until_ns) {
    const std::string packet = ForgedAnnouncement((options.peer << 20U) + sent, tag);
    for (std::uint32_t program = 0; program < kPrograms; ++program) {
      sockaddr_in to{};
      to.sin_family = AF_INET;
      to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
      to.sin_port = htons(static_cast<std::uint16_t>(DiscoveryPort(options.domain, program)));
      if (sendto(out, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&to),
                 sizeof to) > 0) {
        ++sent;
      }
    }
  }
  close(out);
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

Result<std::uint64_t> Flood(Attack attack, const DdsOptions& options, double seconds) {
  const auto length_ns = static_cast<std::int64_t>(1e9 * seconds);
  if (attack == Attack::kPackets) return FloodPackets(options, MonotonicNow_ns() + length_ns);
  Flooder flooder(options);
  if (const std::optional<Error> error = flooder.Open(options)) return *error;
  flooder.Presence("flood");
  std::uint64_t sent = 0;
  const std::int64_t until_ns = MonotonicNow_ns() + length_ns;
  std::int64_t beat_ns = 0;
  for (std::int64_t now_ns = 0; (now_ns = MonotonicNow_ns()) < until_ns; ++sent) {
    if (attack == Attack::kNames) {
      flooder.Presence("flood-" + std::to_string(sent));
      continue;
    }
    if (now_ns - beat_ns > kBeatEveryNs) {
      flooder.Presence("flood");
      beat_ns = now_ns;
    }
    flooder.State(attack == Attack::kKeys ? static_cast<ObjectId>(sent) : 0);
  }
  return sent;
}

}  // namespace tandem
