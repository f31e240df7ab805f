#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "collab/peer/peer.h"
#include "collab/receive/peer_inbox.h"
#include "collab/receive/sent_states.h"
#include "collab/session/peer_directory.h"
#include "collab/session/transport.h"
#include "engine/realtime/clock.h"
#include "engine/realtime/triple_buffer.h"

namespace tandem {

struct NodeOptions {
  PeerOptions peer;
  std::string name;
  /// Manifest offered to later peers: the session's where one was adopted, ours otherwise. Nullopt:
  /// made from the scene, without hashes of its files.
  std::optional<SceneManifest> manifest;
  LinkConditions conditions;                         // link of samples heard
  std::size_t waiting = PeerInbox::kDefaultWaiting;  // most samples under way
  double publish_hz = 1000;                          // rate of states and links
  WorkerPool* workers = nullptr;  // workers of the haptic thread; must outlive the node
  ForceTerms terms;  // told to others, with the present layer and displacement; no law: not told
};

/// An active peer without its threads. In the product each of the three frames below has its own
/// thread (haptic, sender, control); the simulated session calls them one after another.
class PeerNode {
 public:
  /// `scene_hash`: hash of the content, as in SceneHash.
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
  /// Publishes the newest frame where it is due; called at least at publish_hz. Returns false if
  /// there has been no frame since the last call.
  bool SendFrame(std::int64_t now_ns, Transport& transport) TANDEM_RUNS_ON(kSenderThread);
  /// Publishes this peer's information when it changes and five times a second, and its manifest
  /// once when offered and once when under way. Called some 50 times a second.
  void ControlFrame(std::int64_t now_ns, Transport& transport) TANDEM_RUNS_ON(kControlThread);
  /// Hands on our bodies and says goodbye; after the last of the three frames.
  void Leave(std::int64_t now_ns, Transport& transport);
  /// Returns the news since the last call, a line each: on peers and on bodies. `on_hand`: called
  /// first with each news of a body, and its line for a user without a terminal.
  using OnHand = std::function<void(const Notification& notification, const std::string& line)>;
  std::vector<std::string> TakeNotifications(const OnHand& on_hand = {})
      TANDEM_RUNS_ON(kControlThread);
  /// Counts of the states of held bodies, sent and due; read after the last SendFrame().
  const SentStates& sent_states() const noexcept { return sent_states_; }
  /// Returns whether as many peers as a session takes were here first, by their beats
  /// (PeerDirectory).
  bool IsBeyondLimit() const { return directory_.CameBefore(info_.beat) >= kMaxPeers; }
  /// Returns whether another program uses our keys, and did so first.
  bool IsTwin() const { return directory_.TwinCameBefore(info_.beat); }
  /// The number of our user's colour; 0: not chosen yet. For the control thread.
  PersonColour colour() const noexcept { return info_.colour; }
  /// The manifest that this peer offers.
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

  /// `typed`: the user can type commands, so that the line may name them.
  std::string DescribeNotification(const Notification& notification, bool typed) const;
  void SendEvents(Transport& transport);

  // sender thread
  std::uint32_t seen_seq_ = 0;
  SentStates sent_states_;
  std::int64_t next_state_ns_ = 0;
  std::vector<std::int64_t> next_loose_ns_;  // by object
  std::int64_t next_view_ns_ = 0;

  // control thread
  PeerInfo info_;
  SceneManifest manifest_;
  std::int64_t under_way_ns_ = 0;  // when the session goes by our manifest; 0: not offered yet
  std::int64_t next_info_ns_ = 0;
};

/// ns; the sender's phase after the haptic thread, when most frames are done. With an arbitrary
/// phase the sender could look just as a frame ends, and take one frame twice and miss another.
inline constexpr std::int64_t kSenderPhaseNs = 250'000;

/// Runs the sender's millisecond: SendFrame(), again after a quarter and half a millisecond if
/// there is no new frame yet. So every frame that is done in time is sent once.
void SendWhenDone(PeerNode& node, Transport& transport, LoopClock& clock)
    TANDEM_RUNS_ON(kSenderThread);

}  // namespace tandem
