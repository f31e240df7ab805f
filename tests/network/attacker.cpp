// A program that does what no sound one does, for the tests; it has the product's message types and
// none of its checks:
//   attacker SESSION KEYS ID MODE SECONDS [INTERFACE]
// KEYS is a member's folder or "-". It speaks as ID (the keys' id in a secured session), over the
// interface (else over loopback), by the modes:
//   flood   states of one body, as fast as can be
//   keys    states of ever new bodies
//   ends    ends of ever new instances, without data, on every topic
//   flap    comes and goes
//   name    is called by bytes that are no text
//   scenes  manifests of ever new authors, some of them by writers in those authors' partitions
//   views   pictures with ever new bodies
//   lookers presence of ever new viewers
//   packets announcements of ever new programs, by a plain socket
// It says "joined" when it can write, is just there for 1.5 s, and says "sent N" at the end.
#include <chrono>
#include <cstdio>
#include <cstring>
#include <string>

#include <dds/dds.h>
#undef restrict

#include "collab/dds/attack.h"
#include "collab/dds/cyclone_log.h"
#include "collab/dds/domain.h"
#include "collab/dds/keys.h"
#include "collab/dds/partitions.h"
#include "collab/dds/qos.h"
#include "collab/dds/security.h"
#include "tandem.h"  // idlc's

namespace {

using namespace tandem;
using Clock = std::chrono::steady_clock;

int Refused(const std::string& why) {
  std::printf("refused: %s\n", why.c_str());
  return 1;
}

class Attacker {
 public:
  /// `name` is the keys', or empty in a plain session.
  Attacker(dds_entity_t participant, PeerId id, const std::string& name)
      : participant_(participant), id_(id) {
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
  bool CanSpeak() const { return infos_ > 0 || lookers_ > 0; }

  void Presence(const std::string& name) {
    tandem_PeerInfo info{};
    info.peer = id_;
    info.protocol = kProtocol;
    info.beat = ++beat_;
    info.role = tandem_ACTIVE;
    std::strncpy(info.name, name.c_str(), sizeof info.name - 1);
    dds_write(infos_, &info);
  }
  void Goodbye() {
    tandem_PeerInfo info{};
    info.peer = id_;
    info.protocol = kProtocol;
    info.leaving = true;
    dds_write(infos_, &info);
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
  // what is written lately is forgotten here, so that this program does not grow itself
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
  dds_entity_t states_ = 0, linked_ = 0, views_ = 0, infos_ = 0, events_ = 0, scenes_ = 0,
               lookers_ = 0;
  std::uint32_t seq_ = 0;
  std::uint32_t beat_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 6) return 2;
  const std::string mode = argv[4];
  TakeOverCycloneLog();
  Qos participant_qos;
  PeerId id = std::stoull(argv[3]);
  std::string key_name;
  if (std::string(argv[2]) != "-") {
    const Result<MemberKeys> keys = LoadMemberKeys(argv[2]);
    if (!keys) return Refused(keys.error().what);
    Result<Qos> qos = SecureParticipantQos(*keys);
    if (!qos) return Refused(qos.error().what);
    participant_qos = *std::move(qos);
    id = keys->peer;
    key_name = keys->name;
  }
  DdsOptions options;
  options.session = argv[1];
  options.interface = argc > 6 ? argv[6] : "lo";
  if (mode == "packets") {
    options.peer = id;
    const Result<std::uint64_t> sent = Flood(tandem::Attack::kPackets, options, {.seconds = std::stod(argv[5])});
    if (!sent) return Refused(sent.error().what);
    std::printf("sent %llu\n", static_cast<unsigned long long>(*sent));
    return 0;
  }
  const Result<Entity> domain = CreateDomain(options);
  if (!domain) return Refused(domain.error().what);
  const Entity participant(dds_create_participant(options.domain, participant_qos.get(), nullptr));
  if (participant.get() < 0) return Refused("no participant");
  Attacker attacker(participant.get(), id, key_name);
  if (!attacker.CanSpeak()) return Refused("no writer");
  std::puts("joined");
  std::fflush(stdout);
  const std::string own_name = mode == "name" ? "b\xff\xc2\x9b\xe2\x80\xae"
                                                "d"
                                              : "vic";
  const auto be_here = [&] {
    // one that floods as a viewer is no peer
    if (mode != "lookers") attacker.Presence(own_name);
  };
  // what a member costs that is just here is no flood's
  for (int i = 0; i < 15; ++i) {
    be_here();
    dds_sleepfor(DDS_MSECS(100));
  }

  const auto end = Clock::now() + std::chrono::duration<double>(std::stod(argv[5]));
  auto beat = Clock::now();
  long sent = 0;
  for (; Clock::now() < end; ++sent) {
    const auto number = static_cast<std::uint32_t>(sent);
    if (mode == "flap") {
      attacker.Presence(own_name);
      dds_sleepfor(DDS_USECS(200));
      attacker.Goodbye();
      dds_sleepfor(DDS_USECS(200));
      continue;
    }
    if (Clock::now() - beat > std::chrono::milliseconds(200)) {
      be_here();
      beat = Clock::now();
    }
    if (mode == "flood") attacker.State(0);
    if (mode == "keys") attacker.State(number);
    if (mode == "ends") attacker.End(number);
    if (mode == "scenes") attacker.Scene(1000 + number);
    if (mode == "views") attacker.View(kMaxViewBodies * number);
    if (mode == "lookers") attacker.Looker(1000 + number);
    if (mode == "name") dds_sleepfor(DDS_MSECS(10));
    // reliable writers wait for no one here, but leave the receivers some time
    if (mode == "scenes" || mode == "ends" || mode == "views" || mode == "lookers")
      dds_sleepfor(DDS_USECS(100));
  }
  std::printf("sent %ld\n", sent);
  return 0;
}
