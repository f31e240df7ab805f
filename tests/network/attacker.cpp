// A program that does what no sound one does, for the tests; it has the product's message types and
// none of its checks:
//   attacker SESSION KEYS ID MODES SECONDS [MOST [INTERFACE [ACCESS-PLUGIN [DOMAIN]]]]
// KEYS is a member's folder or "-". It speaks as ID (the keys' id in a secured session), over the
// interface (else over loopback). With an access-control plug-in of its own it makes writers that
// its permissions do not name ("-": none). MODES are one or more of these, with a plus between two:
//   flood   states of one body, as fast as can be
//   keys    states of ever new bodies
//   names   presence under ever new names, as a peer and as a viewer
//   ends    ends of ever new instances, without data, on every topic
//   events  sound events of all kinds but grants, as a peer that is taken in
//   flap    comes and goes, as a peer and as a viewer
//   name    is called by bytes that are no text
//   scenes  manifests of ever new authors, some of them by writers in those authors' partitions
//   views   pictures with ever new bodies
//   lookers presence of ever new viewers
//   pieces  pieces of one sample that is said to be of a gigabyte, by a plain socket
//   packets announcements of ever new programs, by a plain socket
//   hosts   requests and goals of ever new hosts, to the controller SESSION
// It says "joined" when it can write, and is a quiet member until it gets SIGUSR1. Then it floods
// for so many seconds, or until it has sent MOST, and says "sent N". It does so for each mode; with
// a viewer's keys it is here as a viewer.
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include <arpa/inet.h>
#include <dds/dds.h>
#include <sys/socket.h>
#undef restrict

#include "collab/dds/attack.h"
#include "collab/dds/control_domain.h"
#include "collab/dds/control_wire.h"
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

constexpr std::uint32_t kControlDomain = 43;  // domain that --control takes

constexpr double kPatienceSeconds = 120;  // longest wait for the signal to begin

std::atomic<bool> begun{false};

int Refused(const std::string& why) {
  std::printf("refused: %s\n", why.c_str());
  return 1;
}

int Sent(std::uint64_t count) {
  std::printf("sent %llu\n", static_cast<unsigned long long>(count));
  std::fflush(stdout);
  return 0;
}

/// Says "joined". From here on a signal begins a flood.
void SayJoined() {
  std::signal(SIGUSR1, [](int) {
    begun = true;
  });
  std::puts("joined");
  std::fflush(stdout);
}

/// Calls meanwhile(), ten times a second, until the signal to begin comes.
template <typename Meanwhile>
void AwaitSignal(Meanwhile meanwhile) {
  const auto until = Clock::now() + std::chrono::duration<double>(kPatienceSeconds);
  while (!begun && Clock::now() < until) {
    meanwhile();
    dds_sleepfor(DDS_MSECS(100));
  }
  begun = false;
}

/// Floods with requests and goals of ever new hosts, by one writer of each.
int FloodController(const std::string& name, const FloodPlan& plan) {
  const Result<ControlDomain> control = EnterControlDomain(name, kControlDomain, {});
  if (!control) return Refused(control.error().what);
  const dds_entity_t requests = ControlWriter(control->participant.get(), ControlTopic::kRequest);
  const dds_entity_t goals = ControlWriter(control->participant.get(), ControlTopic::kGoal);
  if (requests <= 0 || goals <= 0) return Refused("no writer");
  SayJoined();
  AwaitSignal([] {});
  const auto end = Clock::now() + std::chrono::duration<double>(plan.seconds);
  std::uint64_t sent = 0;
  for (; Clock::now() < end && (plan.most == 0 || sent < plan.most); ++sent) {
    tandem_control_Request request{};
    request.host = 1000 + sent;
    request.number = 1;
    request.version = kControlVersion;
    request.kind = tandem_control_SNAPSHOT_RATE;
    request.value = 60;
    dds_write(requests, &request);
    tandem_control_Goal goal{};
    goal.host = 1000 + sent;
    dds_write(goals, &goal);
    // or this program grows itself
    dds_unregister_instance(requests, &request);
    dds_unregister_instance(goals, &goal);
  }
  return Sent(sent);
}

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
  std::uint64_t params_hash_ = 0;
};

/// Floods by one mode. `be_here` says that the attacker is here. Returns how much it sent.
std::uint64_t FloodBy(const std::string& mode, const FloodPlan& plan, std::uint32_t domain,
                      Attacker& attacker, const std::function<void()>& be_here) {
  // reliable writers wait for no one here, but leave the receivers some time; a member's are slow
  // by themselves, since they encrypt what they send
  const bool is_slow =
      !attacker.IsMember() && (mode == "scenes" || mode == "ends" || mode == "views" ||
                               mode == "lookers" || mode == "pieces");
  const auto end = Clock::now() + std::chrono::duration<double>(plan.seconds);
  auto beat = Clock::now();
  std::uint64_t sent = 0;
  for (; Clock::now() < end && (plan.most == 0 || sent < plan.most); ++sent) {
    const auto number = static_cast<std::uint32_t>(sent);
    if (mode == "flap") {
      be_here();
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
    if (mode == "names") attacker.Names(number);
    if (mode == "ends") attacker.End(number);
    if (mode == "events") attacker.Event(number);
    if (mode == "scenes") attacker.Scene(1000 + number);
    if (mode == "views") attacker.View(kMaxViewBodies * number);
    if (mode == "lookers") attacker.Looker(1000 + number);
    if (mode == "pieces") attacker.Piece(number, domain);
    if (mode == "name") dds_sleepfor(DDS_MSECS(10));
    if (is_slow && plan.most == 0) dds_sleepfor(DDS_USECS(100));
  }
  return sent;
}

std::vector<std::string> ModesIn(const std::string& text) {
  std::vector<std::string> modes;
  std::istringstream stream(text);
  for (std::string mode; std::getline(stream, mode, '+');) modes.push_back(mode);
  return modes;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 6) return 2;
  const std::vector<std::string> modes = ModesIn(argv[4]);
  const auto is_asked = [&modes](const char* mode) {
    return std::ranges::find(modes, mode) != modes.end();
  };
  const FloodPlan plan{
      .seconds = std::stod(argv[5]), .most = argc > 6 ? std::stoull(argv[6]) : 0, .per_second = 0};
  TakeOverCycloneLog();
  Qos participant_qos;
  PeerId id = std::stoull(argv[3]);
  std::string key_name;
  bool looks_on = false;
  if (std::string(argv[2]) != "-") {
    const Result<MemberKeys> keys = LoadMemberKeys(argv[2]);
    if (!keys) return Refused(keys.error().what);
    Result<Qos> qos = SecureParticipantQos(*keys);
    if (!qos) return Refused(qos.error().what);
    participant_qos = *std::move(qos);
    const bool has_plugin = argc > 8 && std::string(argv[8]) != "-";
    if (has_plugin) dds_qset_prop(participant_qos.get(), "dds.sec.access.library.path", argv[8]);
    id = keys->peer;
    key_name = keys->name;
    looks_on = keys->role == Role::kViewer;
  }
  if (is_asked("hosts")) return FloodController(argv[1], plan);
  DdsOptions options;
  options.session = argv[1];
  options.interface = argc > 7 ? argv[7] : "lo";
  if (argc > 9) options.domain = static_cast<std::uint32_t>(std::stoul(argv[9]));
  if (is_asked("packets")) {
    options.peer = id;
    SayJoined();
    AwaitSignal([] {});
    const Result<std::uint64_t> sent = Flood(tandem::Attack::kPackets, options, plan);
    return sent ? Sent(*sent) : Refused(sent.error().what);
  }
  const Result<Entity> domain = CreateDomain(options);
  if (!domain) return Refused(domain.error().what);
  const Entity participant(dds_create_participant(options.domain, participant_qos.get(), nullptr));
  if (participant.get() < 0) return Refused("no participant");
  Attacker attacker(participant.get(), id, key_name);
  if (!attacker.CanSpeak()) return Refused("no writer");
  if (is_asked("events")) attacker.Learn();
  const std::string own_name = is_asked("name") ? "b\xff\xc2\x9b\xe2\x80\xae"
                                                  "d"
                                                : "vic";
  const auto be_here = [&] {
    if (looks_on) attacker.LookOn(own_name);
    // an attacker that floods as a viewer is no peer
    if (!is_asked("lookers")) attacker.Presence(own_name);
  };

  SayJoined();
  for (const std::string& mode : modes) {
    // a member costs something that is just here, which is no flood's
    AwaitSignal(be_here);
    Sent(FloodBy(mode, plan, options.domain, attacker, be_here));
  }
  return 0;
}
