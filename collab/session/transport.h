#pragma once

#include <cstdint>
#include <string>

#include "collab/session/drop_counts.h"
#include "collab/session/messages.h"

namespace tandem {

/// The receiving end of a transport. `arrival_ns` is the receiver's monotonic clock. States, links
/// and views come on the receive thread and must not block; the rest comes on the control thread.
class Inbox {
 public:
  virtual ~Inbox() = default;
  virtual void OnState(const ObjectState& state, std::int64_t arrival_ns) = 0;
  virtual void OnLinks(const CouplingLinks& links, std::int64_t arrival_ns) = 0;
  virtual void OnView(const ViewFrame& frame, std::int64_t arrival_ns) = 0;
  virtual void OnPeerInfo(const PeerInfo& info, std::int64_t arrival_ns) = 0;
  virtual void OnPeerLeft(PeerId peer) = 0;  // it said goodbye
  virtual void OnPeerLost(PeerId peer) = 0;  // it fell silent; may come back with OnPeerInfo
  virtual void OnEvent(const Event& event, std::int64_t arrival_ns) = 0;
  virtual void OnScene(const SceneManifest& manifest) = 0;
  /// A peer's offer has ended: its writer has gone.
  virtual void OnSceneWithdrawn(PeerId /*peer*/) {}
  /// Another program uses our keys too, and sends this information; in secured sessions.
  virtual void OnTwin(const PeerInfo& /*info*/) {}
  /// A sample that no sound peer sends was dropped; `from`: its owner as far as its path tells, 0:
  /// unknown. Motion on the receive thread, the rest on the control thread.
  virtual void OnDropped(PeerId /*from*/, Drop /*reason*/) {}
};

/// Sends a peer's messages to the others: over DDS in the product, over the simulated network in
/// virtual time. One thread at a time calls each Publish: the sender thread for states, links,
/// views and events, the control thread for the rest. Received messages go to the Inbox given at
/// construction. Destroying it without Leave() looks to other peers like a crash.
class Transport {
 public:
  virtual ~Transport() = default;
  virtual void Publish(const ObjectState& state) = 0;
  /// Publishes both together: a receiver gets both or neither, the state first.
  virtual void Publish(const ObjectState& state, const CouplingLinks& links) = 0;
  virtual void Publish(const ViewFrame& frame) = 0;
  virtual void Publish(const PeerInfo& info) = 0;
  virtual void Publish(const Event& event) = 0;
  virtual void Publish(const SceneManifest& manifest) = 0;
  /// Says goodbye: the other peers get OnPeerLeft at once.
  virtual void Leave() = 0;
  /// Says goodbye and no more, from any thread and at any time: the last act of a program that is
  /// ended by force.
  virtual void SayGoodbye() {}
  /// Returns a line for a person when the keys end now; empty: they do not, or there are none. The
  /// program must leave then, for soon afterwards DDS ends the session.
  virtual std::string KeysEnd() const { return {}; }
};

}  // namespace tandem
