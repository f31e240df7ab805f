// A program that attacks a session, for the tests: it uses the product's message types and none of
// its checks.
//   dds_attacker SESSION KEYS|- ACCESS-PLUGIN|- MODE ID NAME VICTIM-ID
// With the keys in folder KEYS ("-": none), and an access-control plug-in of its own choice, it is
// ID and does what MODE says until its input ends, a thousand times a second, or 40 times with
// "_slowly" behind the mode: no more than an honest peer sends. NAME goes into the partition of its
// presence ("-": none), VICTIM-ID is the peer that it attacks, and whose scene it says it has. Says
// "refused" if it could not even begin, else "attacking".
#include <array>
#include <cstdio>
#include <cstring>
#include <limits>
#include <map>
#include <string>
#include <string_view>

#include <poll.h>
#include <unistd.h>

#include "collab/dds/cyclone/cyclone_log.h"
#include "collab/dds/cyclone/partitions.h"
#include "collab/dds/cyclone/qos.h"
#include "collab/dds/security/security.h"
#include "collab/dds/transport/domain.h"
#include "tandem.h"

namespace {

using namespace tandem;

int Refused(const std::string& why) {
  std::fprintf(stderr, "%s\n", why.c_str());
  std::puts("refused");
  return 0;
}

bool InputEnds(int within_ms) {
  pollfd wait{STDIN_FILENO, POLLIN, 0};
  return poll(&wait, 1, within_ms) > 0;
}

class Attacker {
 public:
  Attacker(dds_entity_t participant, PeerId self, std::string name, PeerId victim)
      : participant_(participant), self_(self), name_(std::move(name)), victim_(victim) {}

  /// Attacks once by a mode. False: the writer that it takes is refused.
  bool Attack(const std::string& mode) {
    ++turn_;
    const std::string own = PeerPartition(self_);
    const std::string own_presence = name_ == "-" ? own : NamedPartition(own, name_);
    if (mode == "claim") return SayInfo(own_presence, self_, 0xFFFFFFFF);
    if (mode == "claim_next") return SayInfo(own_presence, self_, 2 + turn_ / 8);
    if (mode == "claim_as_victim") return SayInfo(own_presence, victim_, 0xFFFFFFFF);
    if (mode == "sit_down") return SayInfo(PeerPartition(victim_), victim_, 0xFFFFFFFF);
    if (mode == "look_on") return SayViewer(self_);
    if (mode == "look_on_as_victim") return SayViewer(victim_);
    if (mode == "dispose") return Dispose(own_presence);
    if (mode == "end") return Dispose(own_presence) && EndAll();
    if (mode == "say_badly") return SayBadInfo(own_presence) && SayBadScene();
    if (mode == "crowd") return SayCrowd();
    if (mode == "grant") return SayGrant(own, self_);
    if (mode == "grant_here") return SayInfo(own_presence, self_, 0) && SayGrant(own, self_);
    if (mode == "grant_as_victim") return SayGrant(own, victim_);
    if (mode == "offer_as_first") return SayScene(1, 2, 3e-5);
    if (mode == "offer_absurd") return SayScene(self_, 4'000'000'000U, 3e-5);
    if (mode == "offer_fine") {
      return SayInfo(own_presence, self_, 0) && SayScene(self_, SceneManifest::kUnderWay, 3e-5);
    }
    if (mode == "offer_others") {
      // another content, and then the same by voxels that nobody has room for
      const bool other = turn_ % 2 == 0;
      return SayInfo(own_presence, self_, 0) &&
             SayOffer(other ? turn_ : 0, other ? 0 : 3e-5, 0.01 * (turn_ % 50));
    }
    if (mode == "offer_friction") {
      return SayInfo(own_presence, self_, 0) && SayOffer(0, 0, 0.01 * (turn_ % 50));
    }
    if (mode == "state_as_victim") return SayState(PeerPartition(victim_));
    return false;
  }

 private:
  dds_entity_t Topic(const dds_topic_descriptor_t& type, const char* topic) {
    dds_entity_t& made = topics_[topic];
    if (made == 0) made = dds_create_topic(participant_, &type, topic, nullptr, nullptr);
    return made;
  }

  /// Calls use(data) for all that the victim says on a topic, until that returns true or 2 s pass.
  template <typename Wire, typename Use>
  void Hear(const dds_topic_descriptor_t& type, const char* topic, Purpose purpose,
            const char* partitions, Use use) {
    const Qos qos = MakeQos(purpose, partitions);
    const Entity reader(dds_create_reader(participant_, Topic(type, topic), qos.get(), nullptr));
    bool done = false;
    for (int i = 0; i < 200 && !done; ++i) {
      void* sample = nullptr;
      dds_sample_info_t facts{};
      while (dds_take(reader.get(), &sample, &facts, 1, 1) == 1) {
        done = done || (facts.valid_data && use(*static_cast<const Wire*>(sample)));
        dds_return_loan(reader.get(), &sample, 1);
        sample = nullptr;
      }
      dds_sleepfor(DDS_MSECS(10));
    }
  }
  /// Hears the victim's scene: a peer with another one is not taken in.
  void Learn() {
    has_learnt_ = true;
    Hear<tandem_PeerInfo>(tandem_PeerInfo_desc, "peer_info", Purpose::kPresence, kEveryPeer,
                          [this](const tandem_PeerInfo& info) {
                            if (info.peer != victim_) return false;
                            scene_hash_ = info.scene_hash;
                            scene_digest_ = info.scene_digest;
                            params_hash_ = info.params_hash;
                            return true;
                          });
  }
  /// Hears the parameters that the victim offers.
  void LearnOffer() {
    has_learnt_offer_ = true;
    Hear<tandem_SceneManifest>(tandem_SceneManifest_desc, "scene", Purpose::kSubject, kEveryScene,
                               [this](const tandem_SceneManifest& manifest) {
                                 if (manifest.offered_by != victim_) return false;
                                 offer_ = manifest;
                                 // lists of a sample that is given back
                                 offer_.bodies = {};
                                 offer_.mesh_digests = {};
                                 return true;
                               });
  }

  dds_entity_t Writer(const dds_topic_descriptor_t& type, const char* topic, Purpose purpose,
                      const std::string& partition) {
    dds_entity_t& writer = writers_[std::string(topic) + " " + partition];
    if (writer != 0) return writer;
    const dds_entity_t made = Topic(type, topic);
    const Qos qos = MakeQos(purpose, partition);
    return writer = made < 0 ? made : dds_create_writer(participant_, made, qos.get(), nullptr);
  }

  /// Speaks as an active peer that claims four bodies by that epoch; 0: none.
  bool SayInfo(const std::string& partition, PeerId as, std::uint32_t epoch) {
    if (!has_learnt_) Learn();
    const dds_entity_t writer =
        Writer(tandem_PeerInfo_desc, "peer_info", Purpose::kPresence, partition);
    tandem_PeerInfo info{};
    info.peer = as;
    info.protocol = kProtocol;
    info.beat = turn_;
    info.role = tandem_ACTIVE;
    std::snprintf(info.name, sizeof info.name, "mallory");
    info.scene_hash = scene_hash_;
    info.scene_digest = scene_digest_;
    info.params_hash = params_hash_;
    info.incarnation = 666;
    tandem_Claim claims[4];
    for (std::uint32_t i = 0; i < 4; ++i) claims[i] = {i, epoch, true};
    if (epoch > 0) info.claims = {4, 4, claims, false};
    return writer > 0 && dds_write(writer, &info) == DDS_RETCODE_OK;
  }

  bool SayViewer(PeerId as) {
    const std::string own = ViewerPartition(self_);
    const dds_entity_t writer = Writer(tandem_ViewerInfo_desc, "viewer_info", Purpose::kPresence,
                                       name_ == "-" ? own : NamedPartition(own, name_));
    tandem_ViewerInfo info{};
    info.peer = as;
    info.protocol = kProtocol;
    info.beat = turn_;
    info.incarnation = 666;
    std::snprintf(info.name, sizeof info.name, "mallory");
    return writer > 0 && dds_write(writer, &info) == DDS_RETCODE_OK;
  }

  // Touches the victim's instance, so that it has another writer, and disposes of it.
  bool Dispose(const std::string& partition) {
    const dds_entity_t writer =
        Writer(tandem_PeerInfo_desc, "peer_info", Purpose::kPresence, partition);
    tandem_PeerInfo info{};
    info.peer = victim_;
    if (writer <= 0) return false;
    dds_write(writer, &info);
    return dds_dispose(writer, &info) == DDS_RETCODE_OK;
  }

  /// Ends the victim's instances on every topic, in the own partitions and in the victim's.
  bool EndAll() {
    bool all = true;
    const auto end = [&](const dds_topic_descriptor_t& type, const char* topic, Purpose purpose,
                         const std::string& partition, const void* sample) {
      const dds_entity_t writer = Writer(type, topic, purpose, partition);
      all = all && writer > 0;
      dds_dispose(writer, sample);
      if (turn_ % 2 == 0) dds_unregister_instance(writer, sample);
    };
    for (const PeerId in : {self_, victim_}) {
      tandem_ObjectState state{};
      state.peer = victim_;
      state.object = turn_ % 4;
      end(tandem_ObjectState_desc, "state/1", Purpose::kMotion, PeerPartition(in), &state);
      tandem_LinkedState linked{};
      linked.peer = victim_;
      end(tandem_LinkedState_desc, "link/2", Purpose::kMotion, PeerPartition(in), &linked);
      tandem_ViewFrame view{};
      view.peer = victim_;
      end(tandem_ViewFrame_desc, "view/1", Purpose::kMotion, ViewPartition(in), &view);
      tandem_Event event{};
      event.peer = victim_;
      end(tandem_Event_desc, "event", Purpose::kEvent, PeerPartition(in), &event);
      tandem_SceneManifest manifest{};
      manifest.offered_by = victim_;
      end(tandem_SceneManifest_desc, "scene", Purpose::kSubject, ScenePartition(in), &manifest);
      tandem_PeerInfo info{};
      info.peer = victim_;
      end(tandem_PeerInfo_desc, "peer_info", Purpose::kPresence, PeerPartition(in), &info);
      tandem_ViewerInfo viewer{};
      viewer.peer = victim_;
      end(tandem_ViewerInfo_desc, "viewer_info", Purpose::kPresence, ViewerPartition(in), &viewer);
    }
    return all;
  }

  /// Speaks of the victim's scene as a peer that takes part. In each turn one number is none or
  /// beyond measure, or all are sound, and all text is no text.
  bool SayBadInfo(const std::string& partition) {
    if (!has_learnt_) Learn();
    const dds_entity_t writer =
        Writer(tandem_PeerInfo_desc, "peer_info", Purpose::kPresence, partition);
    tandem_PeerInfo info{};
    info.peer = self_;
    info.protocol = kProtocol;
    info.beat = turn_;
    info.role = tandem_ACTIVE;
    info.scene_hash = scene_hash_;
    info.scene_digest = scene_digest_;
    info.params_hash = params_hash_;
    info.incarnation = 666;
    PutBadText(info.name);
    PutBadText(info.law);
    PutBadText(info.gains);
    info.gate = turn_ % 2 == 0;
    info.force_layer = turn_ % 4 == 0 ? kLeast : turn_ % 4 == 1 ? kMost : 1;
    info.displacement = BadNumber(turn_);
    return writer > 0 && dds_write(writer, &info) == DDS_RETCODE_OK;
  }
  bool SayBadScene() {
    if (!has_learnt_offer_) LearnOffer();
    const dds_entity_t writer =
        Writer(tandem_SceneManifest_desc, "scene", Purpose::kSubject, ScenePartition(self_));
    tandem_SceneManifest manifest = offer_;
    manifest.offered_by = self_;
    manifest.revision = SceneManifest::kUnderWay;
    PutBadText(manifest.name);
    PutBadText(manifest.file);
    tandem_BodyDecl body{};
    PutBadText(body.name);
    manifest.bodies = {1, 1, &body, false};
    constexpr std::uint32_t kFields = 6;
    const double bad = BadNumber(turn_ / kFields);
    if (turn_ % kFields == 0) manifest.voxel_size = bad;
    if (turn_ % kFields == 1) manifest.contact_stiffness = bad;
    if (turn_ % kFields == 2) manifest.friction = bad;
    if (turn_ % kFields == 3) manifest.force_layer = turn_ % 4 == 0 ? kLeast : kMost;
    if (turn_ % kFields == 4) manifest.contact_model = 255;
    return writer > 0 && dds_write(writer, &manifest) == DDS_RETCODE_OK;
  }
  static double BadNumber(std::uint32_t which) {
    constexpr std::array kBad{std::numeric_limits<double>::quiet_NaN(),
                              std::numeric_limits<double>::infinity(),
                              -1.0,
                              0.0,
                              1e308,
                              -1e308,
                              std::numeric_limits<double>::denorm_min()};
    return kBad[which % kBad.size()];
  }
  // Fills a text with bytes that are no text, control characters of one byte and of two, and a
  // change of direction.
  template <std::size_t size>
  static void PutBadText(char (&out)[size]) {  // NOLINT(modernize-avoid-c-arrays): idlc's
    constexpr std::string_view kBad = "b\xff\x1b[2J\n\xc2\x9b\xe2\x80\xae%n<h1>";
    for (std::size_t i = 0; i + 1 < size; ++i) out[i] = kBad[i % kBad.size()];
  }

  /// Speaks as thirty peers of the victim's scene.
  bool SayCrowd() {
    bool all = true;
    for (PeerId i = 0; i < 30; ++i) all = SayInfo(PeerPartition(self_ + i), self_ + i, 0) && all;
    return all;
  }

  bool SayGrant(const std::string& partition, PeerId as) {
    const dds_entity_t writer = Writer(tandem_Event_desc, "event", Purpose::kEvent, partition);
    tandem_Event event{};
    event.peer = as;
    event.seq = turn_;
    event.kind = tandem_GRANT;
    event.object = turn_ % 4;
    event.epoch = 2 + turn_;
    event.to = self_;
    event.pose.q[3] = 1;
    return writer > 0 && dds_write(writer, &event) == DDS_RETCODE_OK;
  }

  bool SayScene(PeerId as, std::uint32_t revision, double voxel_size) {
    const dds_entity_t writer =
        Writer(tandem_SceneManifest_desc, "scene", Purpose::kSubject, ScenePartition(self_));
    tandem_SceneManifest manifest{};
    manifest.offered_by = as;
    manifest.revision = revision;
    manifest.content_hash = 4;
    manifest.voxel_size = voxel_size;
    return writer > 0 && dds_write(writer, &manifest) == DDS_RETCODE_OK;
  }

  /// Sends the victim's offer with another content, voxel size (0: the victim's) or friction.
  bool SayOffer(std::uint64_t content, double voxel_size, double friction) {
    if (!has_learnt_offer_) LearnOffer();
    const dds_entity_t writer =
        Writer(tandem_SceneManifest_desc, "scene", Purpose::kSubject, ScenePartition(self_));
    tandem_SceneManifest manifest = offer_;
    manifest.offered_by = self_;
    manifest.revision = SceneManifest::kUnderWay;
    if (content != 0) {
      manifest.content_hash = content;
      std::memcpy(manifest.content_digest.bytes, &content, sizeof content);
    }
    if (voxel_size != 0) manifest.voxel_size = voxel_size;
    manifest.friction = friction;
    return writer > 0 && dds_write(writer, &manifest) == DDS_RETCODE_OK;
  }

  // Sends a state that its epoch marks.
  bool SayState(const std::string& partition) {
    const dds_entity_t writer =
        Writer(tandem_ObjectState_desc, "state/1", Purpose::kMotion, partition);
    tandem_ObjectState state{};
    state.peer = victim_;
    state.epoch = 666;
    state.seq = turn_;
    state.pose.q[3] = 1;
    return writer > 0 && dds_write(writer, &state) == DDS_RETCODE_OK;
  }

  dds_entity_t participant_;
  PeerId self_;
  std::string name_;
  PeerId victim_;
  std::uint32_t turn_ = 0;
  static constexpr std::int32_t kLeast = std::numeric_limits<std::int32_t>::min();
  static constexpr std::int32_t kMost = std::numeric_limits<std::int32_t>::max();
  bool has_learnt_ = false;
  bool has_learnt_offer_ = false;
  tandem_SceneManifest offer_{};
  std::uint64_t scene_hash_ = 0;
  tandem_Sha256 scene_digest_{};
  std::uint64_t params_hash_ = 0;
  std::map<std::string, dds_entity_t> topics_;
  std::map<std::string, dds_entity_t> writers_;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 8) return 2;
  RedirectCycloneLog();
  Qos participant_qos;
  if (std::string(argv[2]) != "-") {
    Result<MemberKeys> keys = LoadMemberKeys(argv[2]);
    if (!keys) return Refused(keys.error().what);
    Result<Qos> qos = SecureParticipantQos(*keys);
    if (!qos) return Refused(qos.error().what);
    participant_qos = *std::move(qos);
    if (std::string(argv[3]) != "-") {
      dds_qset_prop(participant_qos.get(), "dds.sec.access.library.path", argv[3]);
    }
  }
  DdsOptions options;
  options.session = argv[1];
  options.interface = "lo";
  const Result<Entity> domain = CreateDomain(options);
  if (!domain) return Refused(domain.error().what);
  const Entity participant(dds_create_participant(options.domain, participant_qos.get(), nullptr));
  if (participant.get() < 0) return Refused("no participant");
  Attacker attacker(participant.get(), std::stoull(argv[5]), argv[6], std::stoull(argv[7]));
  std::string mode = argv[4];
  constexpr std::string_view kSlowly = "_slowly";
  const bool slowly = mode.ends_with(kSlowly);
  if (slowly) mode.resize(mode.size() - kSlowly.size());
  if (!attacker.Attack(mode)) return Refused("no writer");
  std::puts("attacking");
  std::fflush(stdout);
  while (!InputEnds(slowly ? 25 : 1)) attacker.Attack(mode);
  return 0;
}
