#include "collab/dds/transport/relay.h"

#include <algorithm>
#include <atomic>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include "collab/dds/cyclone/cyclone_log.h"
#include "collab/dds/cyclone/partitions.h"
#include "collab/dds/cyclone/qos.h"
#include "collab/dds/security/keys.h"
#include "collab/dds/security/security.h"
#include "collab/dds/transport/domain.h"
#include "collab/dds/wire/wire.h"
#include "collab/session/sessions_nearby.h"

namespace tandem {

void GoToRelay(DdsOptions& options) {
  options.session += kBehindRelay;
  ++options.domain;
}

bool IsBehindRelay(const DdsOptions& options) {
  return options.session.ends_with(kBehindRelay);
}

namespace {

constexpr dds_duration_t kGoodbyeWait = DDS_MSECS(100);

class DdsRelay final : public Relay {
 public:
  DdsRelay(Entity domain, std::uint32_t number, const dds_qos_t* qos, MemberKeys keys)
      : keys_(std::move(keys)),
        domain_(std::move(domain)),
        participant_(dds_create_participant(number, qos, nullptr)) {}

  bool Open() {
    const auto topic = [this](const dds_topic_descriptor_t& type, const char* name) {
      return dds_create_topic(participant_.get(), &type, name, nullptr, nullptr);
    };
    view_topic_ = topic(tandem_ViewFrame_desc, "view/1");
    info_topic_ = topic(tandem_PeerInfo_desc, "peer_info");
    scene_topic_ = topic(tandem_SceneManifest_desc, "scene");
    count_writer_ = Writer(scene_topic_, Purpose::kSubject, ScenePartition(0));
    return view_topic_ > 0 && info_topic_ > 0 && count_writer_ > 0;
  }

  void OnState(const ObjectState&, std::int64_t) override {}
  void OnLinks(const CouplingLinks&, std::int64_t) override {}
  void OnEvent(const Event&, std::int64_t) override {}

  void OnView(const ViewFrame& frame, std::int64_t /*arrival_ns*/) override {
    const std::scoped_lock lock(mutex_);
    const auto it = peers_.find(frame.peer);
    if (it == peers_.end()) return;
    tandem_ViewFrame wire;
    ToWire(frame, wire);
    if (dds_write(it->second.view.get(), &wire) == DDS_RETCODE_OK) views_passed_on_.fetch_add(1);
  }

  void OnPeerInfo(const PeerInfo& info, std::int64_t /*arrival_ns*/) override {
    // viewers do not see other viewers
    if (info.role != Role::kActive) return;
    const std::scoped_lock lock(mutex_);
    const auto it = peers_.find(info.peer);
    if (it == peers_.end() && peers_.size() >= kMaxRelayed) return;
    Relayed& peer = it == peers_.end() ? Add(info) : it->second;
    peer.incarnation = info.incarnation;
    tandem_PeerInfo wire{};
    if (ToWire(info, wire, info_room_)) dds_write(peer.info.get(), &wire);
  }

  void OnPeerLeft(PeerId peer) override {
    const Relayed gone = TakeOut(peer);
    if (gone.info.get() <= 0) return;
    WriteGoodbye(peer, gone.info.get(), gone.incarnation);
    dds_wait_for_acks(gone.info.get(), kGoodbyeWait);
  }

  // the peer is lost to the viewers too
  void OnPeerLost(PeerId peer) override { TakeOut(peer); }

  // an offer counts when its author is here, whichever of the two is heard first
  void OnScene(const SceneManifest& manifest) override {
    const std::scoped_lock lock(mutex_);
    const PeerId by = manifest.offered_by;
    const bool known = scenes_.contains(by);
    if (!known && scenes_.size() >= kMaxRelayed && !DropSceneOfNobody()) return;
    scenes_[by] = manifest;
    if (const auto it = peers_.find(by); it != peers_.end()) SayScene(it->second, by);
  }

  // replaces the scene's writer by one that has written nothing
  void OnSceneWithdrawn(PeerId peer) override {
    Entity old;  // destroyed after the lock, because that waits for viewers that do not answer
    const std::scoped_lock lock(mutex_);
    scenes_.erase(peer);
    if (const auto it = peers_.find(peer); it != peers_.end()) {
      std::swap(old, it->second.scene);
      it->second.scene = Entity(Writer(scene_topic_, Purpose::kSubject, ScenePartition(peer)));
    }
  }

  void Leave() override {
    SayGoodbyes();
    const std::scoped_lock lock(mutex_);
    peers_.clear();
    participant_.Delete();
    domain_.Delete();
  }

  std::string KeysEnd() const override { return EndOfKeys(keys_); }

  void SayGoodbyes() override {
    std::vector<dds_entity_t> writers;
    {
      // write all goodbyes first, then wait once
      const std::scoped_lock lock(mutex_);
      for (const auto& [peer, relayed] : peers_) {
        WriteGoodbye(peer, relayed.info.get(), relayed.incarnation);
        writers.push_back(relayed.info.get());
      }
    }
    for (const dds_entity_t writer : writers) dds_wait_for_acks(writer, kGoodbyeWait / 4);
  }

  std::uint64_t views_passed_on() const override { return views_passed_on_.load(); }

  std::size_t viewers() const override {
    dds_publication_matched_status_t matched{};
    if (dds_get_publication_matched_status(count_writer_, &matched) != DDS_RETCODE_OK) return 0;
    return matched.current_count;
  }

 private:
  // forged participants may be many
  static constexpr std::size_t kMaxRelayed = 4 * kMaxPeers;

  struct Relayed {
    std::uint64_t incarnation = 0;
    Entity info;
    Entity view;
    Entity scene;
  };

  dds_entity_t Writer(dds_entity_t topic, Purpose purpose, const std::string& partition) {
    const Qos qos = MakeQos(purpose, partition);
    return dds_create_writer(participant_.get(), topic, qos.get(), nullptr);
  }

  Relayed& Add(const PeerInfo& info) {
    const PeerId peer = info.peer;
    Relayed& relayed = peers_[peer];
    const std::string partition = PeerPartition(peer);
    relayed.info =
        Entity(Writer(info_topic_, Purpose::kPresence,
                      keys_.peer != 0 ? NamedPartition(partition, info.name) : partition));
    relayed.view = Entity(Writer(view_topic_, Purpose::kMotion, ViewPartition(peer)));
    tandem_ViewFrame key{};
    key.peer = peer;
    dds_instance_handle_t instance = 0;
    dds_register_instance(relayed.view.get(), &instance, &key);
    relayed.scene = Entity(Writer(scene_topic_, Purpose::kSubject, ScenePartition(peer)));
    if (scenes_.contains(peer)) SayScene(relayed, peer);
    return relayed;
  }

  // Writes the scene that the peer offers; there must be one.
  void SayScene(const Relayed& relayed, PeerId peer) {
    tandem_SceneManifest wire{};
    if (ToWire(scenes_.at(peer), wire, scene_room_)) dds_write(relayed.scene.get(), &wire);
  }

  /// Takes the peer out. The caller closes its writers without the lock, so that no picture waits
  /// for it. The peer's offer is kept until it is withdrawn, because the peer may come back.
  Relayed TakeOut(PeerId peer) {
    const std::scoped_lock lock(mutex_);
    const auto it = peers_.find(peer);
    if (it == peers_.end()) return {};
    Relayed gone = std::move(it->second);
    peers_.erase(it);
    return gone;
  }

  /// Forgets an offer whose author is not here. False: there is none.
  bool DropSceneOfNobody() {
    const auto nobodys = std::ranges::find_if(scenes_, [this](const auto& one) {
      return !peers_.contains(one.first);
    });
    if (nobodys == scenes_.end()) return false;
    scenes_.erase(nobodys);
    return true;
  }

  static void WriteGoodbye(PeerId peer, dds_entity_t writer, std::uint64_t incarnation) {
    const auto last = GoodbyeOf<tandem_PeerInfo>(peer, incarnation);
    dds_write(writer, &last);
  }

  const MemberKeys keys_;  // empty in a plain session
  Entity domain_;
  Entity participant_;
  dds_entity_t view_topic_ = 0;
  dds_entity_t info_topic_ = 0;
  dds_entity_t scene_topic_ = 0;
  dds_entity_t count_writer_ = 0;  // writes nothing; its readers are the viewers
  std::atomic<std::uint64_t> views_passed_on_ = 0;

  std::mutex mutex_;  // guards all below
  std::map<PeerId, Relayed> peers_;
  std::map<PeerId, SceneManifest> scenes_;  // key: author
  InfoBuffers info_room_;
  ManifestBuffers scene_room_;
};

}  // namespace

Result<std::unique_ptr<Relay>> Relay::Open(const DdsOptions& viewers) {
  RedirectCycloneLog();
  MemberKeys keys;
  Qos qos;
  if (!viewers.secure.empty()) {
    Result<MemberKeys> loaded = LoadMemberKeys(viewers.secure);
    if (!loaded) return loaded.error();
    keys = *std::move(loaded);
    if (!keys.relay) {
      return Error{viewers.secure +
                   ": these are no keys of a relay; 'tandem keys relay' makes some"};
    }
    Result<Qos> secured = SecureParticipantQos(keys);
    if (!secured) return secured.error();
    qos = *std::move(secured);
  }
  Result<Entity> domain = CreateDomain(viewers);
  if (!domain) return domain.error();
  CycloneLogCapture log;
  auto relay = std::make_unique<DdsRelay>(*std::move(domain), viewers.domain, qos.get(), keys);
  if (!relay->Open()) {
    const std::string logged = log.Take();
    if (qos != nullptr) return Error{ExplainRefusal(logged, keys)};
    return Error{"cannot open the viewers' side of the relay" +
                 (logged.empty() ? "" : ": " + logged)};
  }
  return std::unique_ptr<Relay>(std::move(relay));
}

}  // namespace tandem
