#pragma once

#include <atomic>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "collab/session/scene_agreement.h"
#include "collab/session/transport.h"

namespace tandem {

/// Receives for a peer that is still loading and has not chosen its scene, so that the peer learns
/// the session's scene and members. The other peers do not know of it yet, for it has sent nothing.
/// It keeps members and offered scenes. States and events are dropped, for there is nothing they
/// could move.
class EarlyInbox : public Inbox {
 public:
  /// Most members kept; forged participants may be many.
  static constexpr std::size_t kMost = 128;

  /// Returns the session's scene; nullopt if no peer has offered any yet.
  std::optional<SceneManifest> SessionScene() const;
  /// Returns whether a peer is here.
  bool HasPeers() const;
  /// Returns the name of a peer that is here; empty if it is not known.
  std::string NameOf(PeerId peer) const;
  /// Returns whether another program uses this peer's keys.
  bool has_twin() const noexcept { return twin_; }
  /// Tells `inbox` all that is known; from then on everything goes there. `inbox` must outlive the
  /// transport. Called once.
  void HandOver(Inbox& inbox);

  void OnState(const ObjectState& state, std::int64_t arrival_ns) override;
  void OnLinks(const CouplingLinks& links, std::int64_t arrival_ns) override;
  void OnView(const ViewFrame& frame, std::int64_t arrival_ns) override;
  void OnDropped(PeerId from, Drop reason) override;
  void OnPeerInfo(const PeerInfo& info, std::int64_t arrival_ns) override;
  void OnPeerLeft(PeerId peer) override;
  void OnPeerLost(PeerId peer) override;
  void OnEvent(const Event& event, std::int64_t arrival_ns) override;
  void OnScene(const SceneManifest& manifest) override;
  void OnSceneWithdrawn(PeerId peer) override;
  void OnTwin(const PeerInfo& info) override;

 private:
  struct ReceivedMessage {
    PeerInfo info;
    std::int64_t arrival_ns = 0;
  };

  void Forget(PeerId peer);

  std::atomic<Inbox*> next_{nullptr};  // set under mutex_
  std::atomic<bool> twin_{false};
  mutable std::mutex mutex_;
  std::map<PeerId, ReceivedMessage> here_;
  SceneOffers offers_;
};

}  // namespace tandem
