#pragma once

#include <atomic>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "collab/scene_agreement.h"
#include "collab/transport.h"

namespace tandem {

/// What reaches a peer before it knows by which scene to simulate: it listens already while it
/// loads, so that it knows the session's scene and whom it will meet. Nobody knows of it yet, for
/// it has said nothing. Keeps who is here and what is offered; states and events are not kept, for
/// there is nothing that they could move.
class EarlyInbox : public Inbox {
 public:
  /// Those kept; forged participants may be many.
  static constexpr std::size_t kMost = 128;

  /// The session's scene; nothing: nobody has offered any yet.
  std::optional<SceneManifest> SessionScene() const;
  /// How a peer that is here calls itself; empty: it is not known.
  std::string NameOf(PeerId peer) const;
  /// Whether another program uses our keys.
  bool has_twin() const noexcept { return twin_; }
  /// Tells `inbox` all that is known, and from then on everything goes there. It must outlive the
  /// transport. Once.
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
  struct Heard {
    PeerInfo info;
    std::int64_t arrival_ns = 0;
  };

  void Forget(PeerId peer);

  std::atomic<Inbox*> next_{nullptr};  // set under mutex_
  std::atomic<bool> twin_{false};
  mutable std::mutex mutex_;
  std::map<PeerId, Heard> here_;
  SceneOffers offers_;
};

}  // namespace tandem
