#include "collab/dds/transport/dds_transport.h"

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <optional>
#include <random>
#include <string>
#include <utility>

#include "collab/dds/cyclone/cyclone_log.h"
#include "collab/dds/cyclone/qos.h"
#include "collab/dds/security/security.h"
#include "collab/dds/transport/control_thread.h"
#include "collab/dds/transport/domain.h"
#include "collab/dds/transport/fast_reader.h"
#include "collab/dds/transport/file_thread.h"
#include "collab/dds/wire/wire.h"

namespace tandem {
namespace {

// Time for which a goodbye waits for its readers' acknowledgements.
constexpr dds_duration_t kGoodbyeWait = DDS_MSECS(100);
// Samples of presence that may wait for the control thread.
constexpr int kPresenceDepth = 16;

std::uint64_t NewIncarnation() {
  std::random_device random;
  std::uint64_t number = 0;
  while (number == 0) number = static_cast<std::uint64_t>(random()) << 32U | random();
  return number;
}

struct Topics {
  dds_entity_t state = 0;
  dds_entity_t linked = 0;
  dds_entity_t view = 0;
  dds_entity_t event = 0;
  dds_entity_t peer_info = 0;
  dds_entity_t viewer_info = 0;
  dds_entity_t scene = 0;
};

struct Writers {
  dds_entity_t state = 0;  // 0: a viewer has none
  dds_entity_t linked = 0;
  dds_entity_t view = 0;
  dds_entity_t event = 0;
  dds_entity_t presence = 0;  // for peer_info, or a viewer's for viewer_info
  dds_entity_t scene = 0;
};

void HandState(Inbox& inbox, const ObjectState& state, std::int64_t arrival_ns) {
  inbox.OnState(state, arrival_ns);
}
void HandLinked(Inbox& inbox, const LinkedState& linked, std::int64_t arrival_ns) {
  inbox.OnState(linked.state, arrival_ns);
  inbox.OnLinks(linked.links, arrival_ns);
}
void HandView(Inbox& inbox, const ViewFrame& frame, std::int64_t arrival_ns) {
  inbox.OnView(frame, arrival_ns);
}

class DdsTransport final : public Transport {
 public:
  DdsTransport(const DdsOptions& options, Inbox& inbox, Entity domain, const dds_qos_t* qos,
               const MemberKeys& keys)
      : options_(options),
        keys_(keys),
        inbox_(inbox),
        domain_(std::move(domain)),
        participant_(dds_create_participant(options.domain, qos, nullptr)),
        on_match_(dds_create_guardcondition(participant_.get())),
        states_(inbox, HandState, options, on_match_),
        linked_(inbox, HandLinked, options, on_match_),
        views_(inbox, HandView, options, on_match_) {}
  ~DdsTransport() override { Close(); }

  /// Makes all entities below the participant. Returns the first failure, or nothing.
  std::optional<Error> Open() {
    Note(participant_.get(), "the participant");
    OpenTopics();
    OpenWriters();
    RegisterObjects();
    OpenReaders();
    if (failed_.has_value()) return failed_;
    control_.emplace(ControlThread::Sources{.participant = participant_.get(),
                                            .peer_info = peer_info_reader_,
                                            .viewer_info = viewer_info_reader_,
                                            .scene = scene_reader_,
                                            .event = event_reader_,
                                            .on_match = on_match_,
                                            .quiet = &quiet_,
                                            .secured = !options_.secure.empty(),
                                            .revoked = keys_.revoked,
                                            .domain = options_.domain},
                     options_.peer, inbox_, [this](const Seats& seats) {
                       RefreshOwners(seats);
                     });
    if (options_.files != nullptr && !IsBehindRelay(options_)) {
      files_ = FileThread::Start(
          {.participant = participant_.get(), .self = options_.peer, .role = options_.role},
          *options_.files, inbox_);
      if (!files_) ReportDdsMessage("scene files cannot be sent or fetched in this session");
    }
    return std::nullopt;
  }

  // Numbers states anew, over all bodies and both topics, so that a gap means a loss on the way.
  void Publish(const ObjectState& state) override {
    ObjectState numbered = state;
    numbered.seq = ++states_sent_;
    PublishFast<tandem_ObjectState>(writers_.state, numbered);
  }
  void Publish(const ObjectState& state, const CouplingLinks& links) override {
    CopyUsed(sending_.links, links);
    sending_.state = state;
    sending_.state.seq = ++states_sent_;
    PublishFast<tandem_LinkedState>(writers_.linked, sending_);
  }
  void Publish(const ViewFrame& frame) override {
    PublishFast<tandem_ViewFrame>(writers_.view, frame);
  }
  void Publish(const PeerInfo& info) override {
    if (said_goodbye_.load()) return;  // the program ends by force, unseen by this thread yet
    PeerInfo announced = info;
    announced.incarnation = incarnation_;
    SayPresence(announced);
  }
  void Publish(const Event& event) override { PublishFast<tandem_Event>(writers_.event, event); }
  void Publish(const SceneManifest& manifest) override {
    tandem_SceneManifest wire{};
    ManifestBuffers room;
    CountUnless(ToWire(manifest, wire, room) && dds_write(writers_.scene, &wire) == DDS_RETCODE_OK);
  }

  void Leave() override {
    if (participant_.get() <= 0) return;
    SayGoodbye();
    Close();
  }
  // Says goodbye by a sample, not by disposing, because any writer of the topic can dispose of any
  // instance. It touches nothing that other threads of this program use.
  void SayGoodbye() override {
    if (said_goodbye_.exchange(true)) return;
    if (options_.role == Role::kViewer) {
      const auto last = GoodbyeOf<tandem_ViewerInfo>(options_.peer, incarnation_);
      dds_write(writers_.presence, &last);
    } else {
      const auto last = GoodbyeOf<tandem_PeerInfo>(options_.peer, incarnation_);
      dds_write(writers_.presence, &last);
    }
    // if the writer is gone, both calls return an error and do nothing
    dds_wait_for_acks(writers_.presence, kGoodbyeWait);
  }
  std::string KeysEnd() const override { return EndOfKeys(keys_); }

 private:
  void SayPresence(const PeerInfo& info) {
    if (options_.role == Role::kViewer) {
      tandem_ViewerInfo wire{};
      ToWire(info, wire);
      CountUnless(dds_write(writers_.presence, &wire) == DDS_RETCODE_OK);
      return;
    }
    tandem_PeerInfo wire{};
    CountUnless(ToWire(info, wire, info_room_) &&
                dds_write(writers_.presence, &wire) == DDS_RETCODE_OK);
  }
  template <typename Wire, typename Message>
  void PublishFast(dds_entity_t writer, const Message& message) {
    Wire wire;
    ToWire(message, wire);
    CountUnless(dds_write(writer, &wire) == DDS_RETCODE_OK);
  }
  void CountUnless(bool sent) {
    if (!sent) unsent_.fetch_add(1, std::memory_order_relaxed);
  }

  // Keeps the first failure and returns the entity.
  dds_entity_t Note(dds_entity_t entity, const char* what) {
    if (entity < 0 && !failed_.has_value()) {
      failed_ = Error{std::string("cannot make ") + what + ": " + dds_strretcode(entity)};
    }
    return entity;
  }

  void OpenTopics() {
    const auto open = [this](const dds_topic_descriptor_t& type, const char* name) {
      return Note(dds_create_topic(participant_.get(), &type, name, nullptr, nullptr), name);
    };
    topics_.view = open(tandem_ViewFrame_desc, "view/1");
    topics_.peer_info = open(tandem_PeerInfo_desc, "peer_info");
    topics_.viewer_info = open(tandem_ViewerInfo_desc, "viewer_info");
    topics_.scene = open(tandem_SceneManifest_desc, "scene");
    // a viewer's permissions do not cover the other topics
    if (options_.role == Role::kViewer) return;
    topics_.state = open(tandem_ObjectState_desc, "state/1");
    topics_.linked = open(tandem_LinkedState_desc, "link/2");
    topics_.event = open(tandem_Event_desc, "event");
  }

  void OpenWriters() {
    const auto open = [this](dds_entity_t topic, Purpose purpose, const std::string& partition) {
      const Qos qos = MakeQos(purpose, partition);
      return Note(dds_create_writer(participant_.get(), topic, qos.get(), nullptr), "a writer");
    };
    const bool looks_on = options_.role == Role::kViewer;
    const std::string partition =
        looks_on ? ViewerPartition(options_.peer) : PeerPartition(options_.peer);
    writers_.presence =
        open(looks_on ? topics_.viewer_info : topics_.peer_info, Purpose::kPresence,
             options_.secure.empty() ? partition : NamedPartition(partition, keys_.name));
    if (looks_on) return;
    writers_.state = open(topics_.state, Purpose::kMotion, partition);
    writers_.linked = open(topics_.linked, Purpose::kMotion, partition);
    writers_.event = open(topics_.event, Purpose::kEvent, partition);
    writers_.view = open(topics_.view, Purpose::kMotion, ViewPartition(options_.peer));
    writers_.scene = open(topics_.scene, Purpose::kSubject, ScenePartition(options_.peer));
  }

  // DDS would make an unregistered instance and drop it again at each write.
  void RegisterObjects() {
    if (options_.role == Role::kViewer || failed_.has_value()) return;
    const auto add = [this](dds_entity_t writer, const auto& key) {
      dds_instance_handle_t instance = 0;
      Note(dds_register_instance(writer, &instance, &key), "an instance");
    };
    for (const ObjectId object : options_.objects) {
      tandem_ObjectState state{};
      state.peer = options_.peer;
      state.object = object;
      add(writers_.state, state);
    }
    tandem_LinkedState linked{};
    linked.peer = options_.peer;
    add(writers_.linked, linked);
    tandem_ViewFrame view{};
    view.peer = options_.peer;
    add(writers_.view, view);
  }

  void OpenReaders() {
    const dds_entity_t participant = participant_.get();
    const auto open_gated = [&](dds_entity_t topic, Purpose purpose, const Qos& qos,
                                const dds_listener_t* listener) {
      return Note(CreateRateLimitedReader(participant, topic, qos.get(), listener,
                                          LimitsOf(purpose, IsBehindRelay(options_)),
                                          [this](dds_instance_handle_t, Drop reason) {
                                            inbox_.OnDropped(0, reason);
                                          }),
                  "a reader");
    };
    const auto open = [&](dds_entity_t topic, Purpose purpose, const char* partition) {
      return open_gated(topic, purpose, MakeQos(purpose, partition), nullptr);
    };
    if (options_.role == Role::kViewer) {
      const Qos qos = MakeQos(Purpose::kMotion, kEveryView);
      Note(views_.Open(participant, topics_.view, qos), "the reader of view/1");
    } else {
      const Qos qos = MakeQos(Purpose::kMotion, kEveryPeer);
      Note(states_.Open(participant, topics_.state, qos), "the reader of state/1");
      event_reader_ = open(topics_.event, Purpose::kEvent, kEveryPeer);
      Note(linked_.Open(participant, topics_.linked, qos), "the reader of link/2");
    }
    const Listener listener = quiet_.MakeListener(on_match_);
    const auto open_presence = [&](dds_entity_t topic, const char* partition) {
      const Qos qos = MakeQos(Purpose::kPresence, partition);
      // a stranger's samples in a peer's instance must not push out the peer's own
      dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, kPresenceDepth);
      return open_gated(topic, Purpose::kPresence, qos, listener.get());
    };
    peer_info_reader_ = open_presence(topics_.peer_info, kEveryPeer);
    viewer_info_reader_ = open_presence(topics_.viewer_info, kEveryViewer);
    const Listener on_scene(dds_create_listener(this));
    dds_lset_subscription_matched(
        on_scene.get(), [](dds_entity_t, const dds_subscription_matched_status_t, void* self) {
          dds_set_guardcondition(static_cast<DdsTransport*>(self)->on_match_, true);
        });
    scene_reader_ = open_gated(topics_.scene, Purpose::kSubject,
                               MakeQos(Purpose::kSubject, kEveryScene), on_scene.get());
  }

  // Runs on the control thread. It reports the first time that a writer has no place.
  void RefreshOwners(const Seats& seats) {
    const std::size_t unheard = std::max(
        {states_.RefreshOwners(seats), linked_.RefreshOwners(seats), views_.RefreshOwners(seats)});
    if (unheard == 0 || std::exchange(told_of_unheard_, true)) return;
    ReportDdsMessage("more than " + std::to_string(WriterOwners::kMaxWriters) +
                     " programs send in this session: " + std::to_string(unheard) +
                     " that came last are not heard (--secure keeps strangers out)");
  }

  // Stops the threads first, because they use the readers.
  void Close() {
    if (participant_.get() > 0) Report();
    files_.reset();
    control_.reset();
    participant_.Delete();
    domain_.Delete();
  }

  void Report() const {
    const auto say = [](std::uint64_t count, const char* what) {
      if (count > 0) ReportDdsMessage(std::string(what) + ": " + std::to_string(count));
    };
    say(unsent_.load(), "messages that could not be sent");
  }

  const DdsOptions options_;
  const MemberKeys keys_;  // in a secured session
  const std::uint64_t incarnation_ = NewIncarnation();
  Inbox& inbox_;
  std::optional<Error> failed_;
  std::atomic<std::uint64_t> unsent_ = 0;
  // used by the sender thread
  std::uint32_t states_sent_ = 0;
  LinkedState sending_;
  std::atomic<bool> said_goodbye_ = false;

  Entity domain_;
  Entity participant_;
  const dds_entity_t on_match_;
  SilentWriters quiet_;
  FastReader<tandem_ObjectState, ObjectState> states_;
  FastReader<tandem_LinkedState, LinkedState> linked_;
  FastReader<tandem_ViewFrame, ViewFrame> views_;
  Topics topics_;
  Writers writers_;
  dds_entity_t peer_info_reader_ = 0;
  dds_entity_t viewer_info_reader_ = 0;
  dds_entity_t scene_reader_ = 0;
  dds_entity_t event_reader_ = 0;
  InfoBuffers info_room_;         // lists of the peer_info being sent
  bool told_of_unheard_ = false;  // used by the control thread
  std::optional<ControlThread> control_;
  std::unique_ptr<FileThread> files_;
};

}  // namespace

Result<std::unique_ptr<Transport>> JoinOverDds(const DdsOptions& options, Inbox& inbox) {
  TANDEM_CHECK(options.peer != 0);
  RedirectCycloneLog();
  MemberKeys keys;
  Qos qos;
  if (!options.secure.empty()) {
    Result<MemberKeys> loaded = LoadMemberKeys(options.secure);
    if (!loaded) return loaded.error();
    keys = *std::move(loaded);
    Result<Qos> secured = SecureParticipantQos(keys);
    if (!secured) return secured.error();
    qos = *std::move(secured);
  }
  Result<Entity> domain = CreateDomain(options, !options.secure.empty());
  if (!domain) return domain.error();

  CycloneLogCapture log;
  auto transport =
      std::make_unique<DdsTransport>(options, inbox, *std::move(domain), qos.get(), keys);
  if (const std::optional<Error> error = transport->Open()) {
    const std::string logged = log.Take();
    if (qos != nullptr) return Error{ExplainRefusal(error->what + " " + logged, keys)};
    return Error{"cannot join session '" + options.session + "': " + error->what +
                 (logged.empty() ? "" : " (" + ExplainMessage(logged) + ")")};
  }
  return std::unique_ptr<Transport>(std::move(transport));
}

}  // namespace tandem
