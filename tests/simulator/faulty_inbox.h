#pragma once

#include <cstdint>

#include "collab/session/transport.h"

namespace tandem {

/// An inbox with the injected fault of the session. It drops some of what a peer hears, and hands
/// on all else as it is.
class FaultyInbox : public Inbox {
 public:
  /// `inbox` must outlive this one.
  explicit FaultyInbox(Inbox& inbox) : inbox_(&inbox) {}

  void OnState(const ObjectState& state, std::int64_t arrival_ns) override;
  void OnLinks(const CouplingLinks& links, std::int64_t arrival_ns) override;
  void OnView(const ViewFrame& frame, std::int64_t arrival_ns) override;
  void OnPeerInfo(const PeerInfo& info, std::int64_t arrival_ns) override;
  void OnPeerLeft(PeerId peer) override;
  void OnPeerLost(PeerId peer) override;
  void OnEvent(const Event& event, std::int64_t arrival_ns) override;
  void OnScene(const SceneManifest& manifest) override;
  void OnSceneWithdrawn(PeerId peer) override;
  void OnTwin(const PeerInfo& info) override;
  void OnDropped(PeerId from, Drop reason) override;

 private:
  Inbox* inbox_;
};

}  // namespace tandem
