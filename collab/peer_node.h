#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "collab/peer.h"
#include "collab/peer_directory.h"
#include "collab/peer_inbox.h"
#include "collab/sent_states.h"
#include "collab/transport.h"
#include "engine/realtime/clock.h"
#include "engine/realtime/triple_buffer.h"

namespace tandem {

struct NodeOptions {
  PeerOptions peer;
  std::string name;
  /// What is offered to those who come later: the session's manifest where one was adopted, ours
  /// otherwise. Nothing: made from the scene, without its files' hashes.
  std::optional<SceneManifest> manifest;
  LinkConditions conditions;                         // of what it hears
  std::size_t waiting = PeerInbox::kDefaultWaiting;  // samples under way at the most
  double publish_hz = 1000;                          // of states and links
  FrameHelpers* helpers = nullptr;                   // of the haptic thread; must outlive the node
  ForceTerms terms;  // that are told; layer and displacement as they come. No law: none are
};

/// An active peer, whole but for its threads: each of the three frames below belongs to a thread of
/// its own in the product (haptic, sender, control); the simulated session calls them one after the
/// other.
class PeerNode {
 public:
  /// `scene_hash`: of the content, as of SceneHash.
  PeerNode(std::shared_ptr<const WorldModel> model, std::unique_ptr<Device> device,
           std::uint64_t scene_hash, const NodeOptions& options);

  PeerInbox& inbox() noexcept { return inbox_; }
  PeerId id() const noexcept { return options_.peer.id; }
  Peer& peer() noexcept { return peer_; }
  const Peer& peer() const noexcept { return peer_; }
  World& world() noexcept { return world_; }
  const World& world() const noexcept { return world_; }
  PeerDirectory& directory() noexcept { return directory_; }

  /// One haptic frame.
  void HapticFrame(std::int64_t now_ns) noexcept TANDEM_RUNS_ON(kHapticThread);
  /// Publishes the newest frame where its turn has come; called at least at publish_hz. False:
  /// there has been no frame since the last call.
  bool SendFrame(std::int64_t now_ns, Transport& transport) TANDEM_RUNS_ON(kSenderThread);
  /// Says who we are and what we hold, when that has changed and five times a second, and once what
  /// the session is about; called some 50 times a second.
  void ControlFrame(std::int64_t now_ns, Transport& transport) TANDEM_RUNS_ON(kControlThread);
  /// Hands on what we answer for and says goodbye; after the last of the three frames.
  void Leave(std::int64_t now_ns, Transport& transport);
  /// What happened since the last call, a line each: who came and went, what became of bodies.
  /// `on_hand`: called first with each of what became of bodies, and its line.
  using OnHand = std::function<void(const HoldingNews& news, const std::string& line)>;
  std::vector<std::string> TakeNews(const OnHand& on_hand = {}) TANDEM_RUNS_ON(kControlThread);
  /// The states of what we held, as far as they were sent in time; after the last SendFrame().
  const SentStates& sent_states() const noexcept { return sent_states_; }
  /// Whether as many as a session takes were here before us; told by their beats (PeerDirectory).
  bool OneTooMany() const { return directory_.CameBefore(info_.beat) >= kMaxPeers; }
  /// Whether another program uses our keys, and did before us.
  bool IsTwin() const { return directory_.TwinCameBefore(info_.beat); }
  /// What we offer.
  const SceneManifest& manifest() const noexcept { return manifest_; }

 private:
  std::shared_ptr<const WorldModel> model_;
  NodeOptions options_;
  World world_;
  std::unique_ptr<Device> device_;
  PeerDirectory directory_;
  PeerInbox inbox_;
  Peer peer_;
  TripleBuffer<Outbox> outbox_;

  std::string Told(const HoldingNews& news) const;
  void SendEvents(Transport& transport);

  // the sender's
  std::uint32_t seen_seq_ = 0;
  SentStates sent_states_;
  std::int64_t next_state_ns_ = 0;
  std::vector<std::int64_t> next_loose_ns_;  // by object
  std::int64_t next_view_ns_ = 0;

  // the control thread's
  PeerInfo info_;
  SceneManifest manifest_;
  std::int64_t under_way_ns_ = 0;  // when the session goes by what we offer; 0: not offered yet
  std::int64_t next_info_ns_ = 0;
};

/// When the sender begins after the haptic thread, ns: when most frames are done. Left to chance,
/// the one looks as the other ends, and finds now the same frame twice and now the next but one.
inline constexpr std::int64_t kSenderPhaseNs = 250'000;

/// The sender's millisecond: SendFrame(), and while there is no new frame yet again a quarter and
/// half a millisecond later, so that every frame that is done in time is sent once.
void SendWhenDone(PeerNode& node, Transport& transport, LoopClock& clock)
    TANDEM_RUNS_ON(kSenderThread);

}  // namespace tandem
