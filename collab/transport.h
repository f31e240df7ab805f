#pragma once

#include <cstdint>
#include <string>

#include "collab/drop_counts.h"
#include "collab/messages.h"

namespace tandem {

/// What reaches a peer, called by a transport. `arrival_ns` is the receiver's monotonic clock.
/// States, links and views come on the receive thread and must not block; the rest on the control
/// thread.
class Inbox {
 public:
  virtual ~Inbox() = default;
  virtual void OnState(const ObjectState& state, std::int64_t arrival_ns) = 0;
  virtual void OnLinks(const CouplingLinks& links, std::int64_t arrival_ns) = 0;
  virtual void OnView(const ViewFrame& frame, std::int64_t arrival_ns) = 0;
  virtual void OnPeerInfo(const PeerInfo& info, std::int64_t arrival_ns) = 0;
  virtual void OnPeerLeft(PeerId peer) = 0;  // said goodbye
  virtual void OnPeerLost(PeerId peer) = 0;  // fell silent; may come back with OnPeerInfo
  virtual void OnEvent(const Event& event, std::int64_t arrival_ns) = 0;
  virtual void OnScene(const SceneManifest& manifest) = 0;
  /// What a peer offered is not on offer any more: its writer has gone.
  virtual void OnSceneWithdrawn(PeerId /*peer*/) {}
  /// Our keys are in use by another program too, which says this; in secured sessions.
  virtual void OnTwin(const PeerInfo& /*info*/) {}
  /// A sample that no sound peer sends was dropped; `from`: whose it was as far as the way it came
  /// tells, 0: nobody's. Of motion on the receive thread, the rest on the control thread.
  virtual void OnDropped(PeerId /*from*/, Drop /*reason*/) {}
};

/// A peer's way to the others: over DDS in the product, over the simulated network in virtual time.
/// Each Publish is called by one thread at a time: states, links, views and events by the sender
/// thread, the rest by the control thread. What it hears goes to the Inbox it was made with.
/// Destroying it without Leave() looks to the others like a crash.
class Transport {
 public:
  virtual ~Transport() = default;
  virtual void Publish(const ObjectState& state) = 0;
  /// Together: what hears the one hears the other, the state first.
  virtual void Publish(const ObjectState& state, const CouplingLinks& links) = 0;
  virtual void Publish(const ViewFrame& frame) = 0;
  virtual void Publish(const PeerInfo& info) = 0;
  virtual void Publish(const Event& event) = 0;
  virtual void Publish(const SceneManifest& manifest) = 0;
  /// Says goodbye: the others get OnPeerLeft at once.
  virtual void Leave() = 0;
  /// Says goodbye and no more, from any thread, whatever the others of this program are doing: what
  /// is left to do when it is ended by force.
  virtual void SayGoodbye() {}
  /// Says that the keys end now, in a line for a person; empty: they do not, or there are none. The
  /// program must leave then: a moment later DDS takes the session from under it.
  virtual std::string KeysEnd() const { return {}; }
};

}  // namespace tandem
