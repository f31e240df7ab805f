#pragma once

#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>

#include <arpa/inet.h>
#include <dds/dds.h>
#include <sys/socket.h>
#undef restrict

#include "collab/dds/cyclone/partitions.h"
#include "collab/dds/cyclone/qos.h"
#include "collab/dds/transport/domain.h"
#include "tandem.h"  // idlc's

namespace tandem::testing {

/// Writes samples that no sound peer writes, by the product's message types.
class Attacker {
 public:
  /// `name` is the keys', or empty in a plain session.
  Attacker(dds_entity_t participant, PeerId id, const std::string& name)
      : participant_(participant), id_(id), is_member_(!name.empty()) {
    const std::string own = PeerPartition(id);
    states_ = Writer(tandem_ObjectState_desc, "state/1", Purpose::kMotion, PeerPartition(id));
    linked_ = Writer(tandem_LinkedState_desc, "link/2", Purpose::kMotion, PeerPartition(id));
    views_ = Writer(tandem_ViewFrame_desc, "view/1", Purpose::kMotion, ViewPartition(id));
    infos_ = Writer(tandem_PeerInfo_desc, "peer_info", Purpose::kPresence,
                    name.empty() ? own : NamedPartition(own, name));
    events_ = Writer(tandem_Event_desc, "event", Purpose::kEvent, PeerPartition(id));
    scenes_ = Writer(tandem_SceneManifest_desc, "scene", Purpose::kSubject, ScenePartition(id));
    const std::string looks_on = ViewerPartition(id);
    lookers_ = Writer(tandem_ViewerInfo_desc, "viewer_info", Purpose::kPresence,
                      name.empty() ? looks_on : NamedPartition(looks_on, name));
  }
  bool IsMember() const { return is_member_; }
  bool CanSpeak() const { return infos_ > 0 || lookers_ > 0; }

  void Presence(const std::string& name) {
    tandem_PeerInfo info{};
    info.peer = id_;
    info.protocol = kProtocol;
    info.beat = ++beat_;
    info.role = tandem_ACTIVE;
    info.scene_hash = scene_hash_;
    info.scene_digest = scene_digest_;
    info.params_hash = params_hash_;
    std::strncpy(info.name, name.c_str(), sizeof info.name - 1);
    dds_write(infos_, &info);
  }
  void LookOn(const std::string& name) {
    tandem_ViewerInfo info{};
    info.peer = id_;
    info.protocol = kProtocol;
    info.beat = ++beat_;
    std::strncpy(info.name, name.c_str(), sizeof info.name - 1);
    dds_write(lookers_, &info);
  }
  void Goodbye() {
    tandem_PeerInfo info{};
    info.peer = id_;
    info.protocol = kProtocol;
    info.leaving = true;
    dds_write(infos_, &info);
    tandem_ViewerInfo looker{};
    looker.peer = id_;
    looker.protocol = kProtocol;
    looker.leaving = true;
    dds_write(lookers_, &looker);
  }
  /// Hears from another peer what the session's scene is: a peer that has it is taken in.
  void Learn() {
    const Qos qos = MakeQos(Purpose::kPresence, kEveryPeer);
    const Entity topic(
        dds_create_topic(participant_, &tandem_PeerInfo_desc, "peer_info", nullptr, nullptr));
    const Entity reader(dds_create_reader(participant_, topic.get(), qos.get(), nullptr));
    for (int i = 0; i < 500 && scene_hash_ == 0; ++i) {
      void* sample = nullptr;
      dds_sample_info_t facts{};
      while (dds_take(reader.get(), &sample, &facts, 1, 1) == 1) {
        const auto& info = *static_cast<const tandem_PeerInfo*>(sample);
        if (facts.valid_data && info.scene_hash != 0) {
          scene_hash_ = info.scene_hash;
          scene_digest_ = info.scene_digest;
          params_hash_ = info.params_hash;
          victim_ = info.peer;
        }
        dds_return_loan(reader.get(), &sample, 1);
        sample = nullptr;
      }
      dds_sleepfor(DDS_MSECS(10));
    }
  }
  void Event(std::uint32_t number) {
    constexpr std::array kKinds{tandem_ASK, tandem_REFUSE, tandem_RELEASE, tandem_HEAL,
                                tandem_TOUCH};
    tandem_Event event{};
    event.peer = id_;
    event.seq = number + 1;
    event.kind = kKinds[number % kKinds.size()];
    event.object = number / kKinds.size() % 4;
    event.epoch = 1;
    event.to = victim_;
    event.pose.q[3] = 1;
    dds_write(events_, &event);
  }
  void State(std::uint32_t object) {
    tandem_ObjectState state{};
    state.peer = id_;
    state.object = object;
    state.epoch = 1;
    state.seq = ++seq_;
    state.pose.q[3] = 1;
    dds_write(states_, &state);
  }
  // samples written lately are forgotten here, so that this program does not grow itself
  void End(std::uint32_t number) {
    tandem_ObjectState state{};
    state.peer = id_;
    state.object = number;
    dds_dispose(states_, &state);
    dds_unregister_instance(states_, &state);
    tandem_Event event{};
    event.peer = number;
    dds_dispose(events_, &event);
    tandem_PeerInfo info{};
    info.peer = number + 1000;
    dds_dispose(infos_, &info);
    tandem_SceneManifest scene{};
    scene.offered_by = number + 1000;
    dds_dispose(scenes_, &scene);
    tandem_ViewerInfo looker{};
    looker.peer = number + 1000;
    dds_dispose(lookers_, &looker);
    dds_unregister_instance(lookers_, &looker);
    tandem_ViewFrame view{};
    view.peer = number + 1000;
    dds_dispose(views_, &view);
    dds_unregister_instance(views_, &view);
    tandem_LinkedState linked{};
    linked.peer = number + 1000;
    dds_dispose(linked_, &linked);
    dds_unregister_instance(linked_, &linked);
  }
  void Scene(std::uint64_t author) {
    tandem_SceneManifest scene{};
    scene.offered_by = author;
    scene.revision = 1;
    std::strncpy(scene.name, "made up", sizeof scene.name - 1);
    scene.voxel_size = 0.001;
    dds_write(scenes_, &scene);
    constexpr std::uint64_t kEvery = 50;  // a writer takes long to make
    if (author % kEvery != 0) return;
    dds_write(Writer(tandem_SceneManifest_desc, "scene", Purpose::kSubject, ScenePartition(author)),
              &scene);
  }
  void Looker(PeerId peer) {
    tandem_ViewerInfo info{};
    info.peer = peer;
    info.protocol = kProtocol;
    info.beat = ++beat_;
    std::snprintf(info.name, sizeof info.name, "looker-%llu",
                  static_cast<unsigned long long>(peer));
    dds_write(lookers_, &info);
    // or this program grows itself
    dds_unregister_instance(lookers_, &info);
  }
  void Names(std::uint32_t number) {
    Presence("vic-" + std::to_string(number));
    LookOn("looker-" + std::to_string(number));
  }
  /// Sends a piece of a state that is never whole (RTPS 2.5, section 9.4.5.5), in this program's
  /// name.
  void Piece(std::uint32_t number, std::uint32_t domain) const {
    constexpr std::uint16_t kPieceBytes = 60'000;
    constexpr std::uint32_t kSampleBytes = 1U << 30U;
    dds_guid_t guid{};
    if (dds_get_guid(states_, &guid) != DDS_RETCODE_OK) return;
    std::string packet{"RTPS\x02\x05\x01\x10", 8};
    const auto put = [&packet](std::uint32_t value, int bytes) {
      for (int i = 0; i < bytes; ++i) packet += static_cast<char>(value >> (8 * i));
    };
    const auto* const id = reinterpret_cast<const char*>(guid.v);
    packet.append(id, 12);
    put(0x16, 1);  // DATA_FRAG
    put(1, 1);     // little endian
    put(32 + kPieceBytes, 2);
    put(0, 2);
    put(28, 2);  // from here to the data
    put(0, 4);   // every reader
    packet.append(id + 12, 4);
    put(0, 4);  // the sample's number, the high half first
    put(1'000'000, 4);
    put(1 + number % (kSampleBytes / kPieceBytes), 4);
    put(1, 2);
    put(kPieceBytes, 2);
    put(kSampleBytes, 4);
    packet.append(kPieceBytes, '\0');
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    to.sin_port = htons(static_cast<std::uint16_t>(DiscoveryPort(domain, 0) + 1));  // port of data
    sendto(socket_, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&to),
           sizeof to);
  }
  void View(std::uint32_t first) {
    tandem_ViewFrame view{};
    view.peer = id_;
    view.seq = ++seq_;
    view.count = kMaxViewBodies;
    for (std::uint32_t i = 0; i < kMaxViewBodies; ++i) {
      view.bodies[i].object = first + i;
      view.bodies[i].q[3] = 1;
    }
    dds_write(views_, &view);
  }

 private:
  dds_entity_t Writer(const dds_topic_descriptor_t& type, const char* topic, Purpose purpose,
                      const std::string& partition) const {
    const Qos qos = MakeQos(purpose, partition);
    const dds_entity_t made = dds_create_topic(participant_, &type, topic, nullptr, nullptr);
    return made < 0 ? made : dds_create_writer(participant_, made, qos.get(), nullptr);
  }

  const dds_entity_t participant_;
  const PeerId id_;
  const bool is_member_;
  const int socket_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);  // it sends what DDS does not
  dds_entity_t states_ = 0, linked_ = 0, views_ = 0, infos_ = 0, events_ = 0, scenes_ = 0,
               lookers_ = 0;
  std::uint32_t seq_ = 0;
  std::uint32_t beat_ = 0;
  PeerId victim_ = 0;
  std::uint64_t scene_hash_ = 0;
  tandem_Sha256 scene_digest_{};
  std::uint64_t params_hash_ = 0;
};

}  // namespace tandem::testing
