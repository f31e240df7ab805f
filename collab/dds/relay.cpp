#include "collab/dds/relay.h"

#include <algorithm>
#include <atomic>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include "collab/dds/cyclone_log.h"
#include "collab/dds/domain.h"
#include "collab/dds/keys.h"
#include "collab/dds/partitions.h"
#include "collab/dds/qos.h"
#include "collab/dds/security.h"
#include "collab/dds/wire.h"
#include "collab/sessions_nearby.h"

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
  DdsRelay(Entity domain, std::uint32_t number, const dds_qos_t* qos)
      : domain_(std::move(domain)), participant_(dds_create_participant(number, qos, nullptr)) {}

  bool Open() {
    const auto topic = [this](const dds_topic_descriptor_t& type, const char* name) {
      return dds_create_topic(participant_.get(), &type, name, nullptr, nullptr);
    };
    view_topic_ = topic(tandem_ViewFrame_desc, "view/1");
    info_topic_ = topic(tandem_PeerInfo_desc, "peer_info");
    const dds_entity_t scene_topic = topic(tandem_SceneManifest_desc, "scene");
    scene_writer_ = Writer(scene_topic, Purpose::kSubject, kScenePartition);
    return view_topic_ > 0 && info_topic_ > 0 && scene_writer_ > 0;
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
    // other viewers are nobody's business
    if (info.role != Role::kActive) return;
    const std::scoped_lock lock(mutex_);
    const auto it = peers_.find(info.peer);
    if (it == peers_.end() && peers_.size() >= kMaxRelayed) return;
    Relayed& peer = it == peers_.end() ? Add(info.peer) : it->second;
    tandem_PeerInfo wire{};
    if (ToWire(info, wire, claims_)) dds_write(peer.info.get(), &wire);
    PassOnSceneOf(info.peer);
  }

  void OnPeerLeft(PeerId peer) override {
    const Relayed gone = TakeOut(peer);
    if (gone.info.get() > 0) SayGoodbye(peer, gone.info.get());
  }

  // gone without a goodbye here as there
  void OnPeerLost(PeerId peer) override { TakeOut(peer); }

  // an offer counts when its author is here, whichever of the two is heard first
  void OnScene(const SceneManifest& manifest) override {
    const std::scoped_lock lock(mutex_);
    const bool known = scenes_.contains(manifest.offered_by);
    if (!known && scenes_.size() >= kMaxRelayed && !DropSceneOfNobody()) return;
    scenes_[manifest.offered_by] = {.manifest = manifest};
    PassOnSceneOf(manifest.offered_by);
  }

  void Leave() override {
    SayGoodbyes();
    const std::scoped_lock lock(mutex_);
    peers_.clear();
    participant_.Delete();
    domain_.Delete();
  }

  void SayGoodbyes() override {
    std::vector<std::pair<PeerId, dds_entity_t>> here;
    {
      const std::scoped_lock lock(mutex_);
      for (const auto& [peer, relayed] : peers_) here.emplace_back(peer, relayed.info.get());
    }
    // all first, then one wait
    for (const auto& [peer, writer] : here) Dispose(peer, writer);
    for (const auto& [peer, writer] : here) dds_wait_for_acks(writer, kGoodbyeWait / 4);
  }

  std::uint64_t views_passed_on() const override { return views_passed_on_.load(); }

  std::size_t viewers() const override {
    dds_publication_matched_status_t matched{};
    if (dds_get_publication_matched_status(scene_writer_, &matched) != DDS_RETCODE_OK) return 0;
    return matched.current_count;
  }

 private:
  // forged participants may be many
  static constexpr std::size_t kMaxRelayed = 4 * kMaxPeers;

  struct Relayed {
    Entity info;
    Entity view;
  };
  struct Offered {
    SceneManifest manifest;
    bool passed_on = false;
  };

  dds_entity_t Writer(dds_entity_t topic, Purpose purpose, const std::string& partition) {
    const Qos qos = MakeQos(purpose, partition);
    return dds_create_writer(participant_.get(), topic, qos.get(), nullptr);
  }

  Relayed& Add(PeerId peer) {
    Relayed& relayed = peers_[peer];
    relayed.info = Entity(Writer(info_topic_, Purpose::kPresence, PeerPartition(peer)));
    relayed.view = Entity(Writer(view_topic_, Purpose::kMotion, ViewPartition(peer)));
    tandem_ViewFrame key{};
    key.peer = peer;
    dds_instance_handle_t instance = 0;
    dds_register_instance(relayed.view.get(), &instance, &key);
    return relayed;
  }

  /// Takes the peer out, with what it offers; its writers are closed by the caller, who holds no lock
  /// that a picture waits for.
  Relayed TakeOut(PeerId peer) {
    const std::scoped_lock lock(mutex_);
    if (const auto scene = scenes_.find(peer); scene != scenes_.end()) {
      if (scene->second.passed_on) {
        tandem_SceneManifest key{};
        key.offered_by = peer;
        dds_dispose(scene_writer_, &key);
        dds_unregister_instance(scene_writer_, &key);
      }
      scenes_.erase(scene);
    }
    const auto it = peers_.find(peer);
    if (it == peers_.end()) return {};
    Relayed gone = std::move(it->second);
    peers_.erase(it);
    return gone;
  }

  void PassOnSceneOf(PeerId peer) {
    const auto scene = scenes_.find(peer);
    if (scene == scenes_.end() || scene->second.passed_on || !peers_.contains(peer)) return;
    tandem_SceneManifest wire{};
    if (!ToWire(scene->second.manifest, wire, bodies_)) return;
    scene->second.passed_on = dds_write(scene_writer_, &wire) == DDS_RETCODE_OK;
  }

  /// Forgets an offer whose author has never been here. False: there is none.
  bool DropSceneOfNobody() {
    const auto nobodys = std::ranges::find_if(scenes_, [this](const auto& one) {
      return !peers_.contains(one.first);
    });
    if (nobodys == scenes_.end()) return false;
    scenes_.erase(nobodys);
    return true;
  }

  static void Dispose(PeerId peer, dds_entity_t writer) {
    tandem_PeerInfo key{};
    key.peer = peer;
    dds_dispose(writer, &key);
  }
  static void SayGoodbye(PeerId peer, dds_entity_t writer) {
    Dispose(peer, writer);
    dds_wait_for_acks(writer, kGoodbyeWait);
  }

  Entity domain_;
  Entity participant_;
  dds_entity_t view_topic_ = 0;
  dds_entity_t info_topic_ = 0;
  dds_entity_t scene_writer_ = 0;
  std::atomic<std::uint64_t> views_passed_on_ = 0;

  std::mutex mutex_;  // of all below
  std::map<PeerId, Relayed> peers_;
  std::map<PeerId, Offered> scenes_;  // by author
  std::vector<tandem_Claim> claims_;
  std::vector<tandem_BodyDecl> bodies_;
};

}  // namespace

Result<std::unique_ptr<Relay>> Relay::Open(const DdsOptions& viewers) {
  TakeOverCycloneLog();
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
  auto relay = std::make_unique<DdsRelay>(*std::move(domain), viewers.domain, qos.get());
  if (!relay->Open()) {
    const std::string said = log.Take();
    if (qos != nullptr) return Error{ExplainRefusal(said, keys)};
    return Error{"cannot open the viewers' side of the relay" + (said.empty() ? "" : ": " + said)};
  }
  return std::unique_ptr<Relay>(std::move(relay));
}

}  // namespace tandem
