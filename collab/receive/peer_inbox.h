#pragma once

#include <atomic>

#include "collab/receive/delivery_count.h"
#include "collab/receive/due_queue.h"
#include "collab/receive/link_conditioner.h"
#include "collab/session/drop_counts.h"
#include "collab/session/peer_directory.h"
#include "collab/session/peer_map.h"
#include "collab/session/transport.h"
#include "engine/realtime/spsc_queue.h"

namespace tandem {

/// A sample and its due time, set by the link conditioner (the receiver's clock).
template <typename T>
struct DueSample {
  std::int64_t due_ns = 0;
  T sample;
};

/// An order to change the conditions of the link from a peer (0: from all).
struct LinkSwitch {
  PeerId from = 0;
  LinkConditions conditions;
};

/// The receiving end of an active peer. States and links pass their sender's conditioner and go
/// into rings, stamped with their due time. The haptic thread takes them when they are due, in that
/// order. Membership goes to the directory.
class PeerInbox : public Inbox {
 public:
  /// Most samples that wait for their time: two seconds of delay from seven peers at 1 kHz, with
  /// some duplicates.
  static constexpr std::size_t kDefaultWaiting = 16384;

  /// `conditions`: those of every sender until Switch() changes them; each sender has its own
  /// random stream.
  PeerInbox(const LinkConditions& conditions, PeerDirectory& directory,
            std::size_t waiting = kDefaultWaiting);

  void OnState(const ObjectState& state, std::int64_t arrival_ns) override;
  void OnLinks(const CouplingLinks& links, std::int64_t arrival_ns) override;
  void OnView(const ViewFrame&, std::int64_t) override {}
  void OnPeerInfo(const PeerInfo& info, std::int64_t) override { directory_->OnPeerInfo(info); }
  void OnPeerLeft(PeerId peer) override { directory_->OnPeerLeft(peer); }
  void OnPeerLost(PeerId peer) override { directory_->OnPeerLost(peer); }
  void OnEvent(const Event& event, std::int64_t arrival_ns) override;
  void OnScene(const SceneManifest& manifest) override { directory_->OnScene(manifest); }
  void OnSceneWithdrawn(PeerId peer) override { directory_->OnSceneWithdrawn(peer); }
  void OnTwin(const PeerInfo& info) override { directory_->OnTwin(info); }
  void OnDropped(PeerId from, Drop reason) override { drops_.Count(from, reason); }

  /// Changes the conditions for samples from `from` (0: from all peers, now and later), beginning
  /// with the next one. Returns false if too many switches are waiting. One thread, the control
  /// one.
  bool Switch(PeerId from, const LinkConditions& conditions) noexcept {
    return switches_.TryPush({from, conditions});
  }

  /// The haptic thread's ends. Collect() first, once a frame: it makes arrived samples visible.
  void Collect() noexcept;
  DueQueue<ObjectState>& states() noexcept { return waiting_states_; }
  DueQueue<CouplingLinks>& links() noexcept { return waiting_links_; }
  SpscQueue<Event>& events() noexcept { return events_; }
  SpscQueue<MembershipChange>& membership() noexcept { return directory_->changes(); }

  /// Samples dropped for lack of room: the haptic thread stood still for seconds, or a sender sent
  /// more than its share.
  std::uint64_t overflows() const noexcept {
    return drops_.Total()[static_cast<std::size_t>(Drop::kRingFull)];
  }
  /// Samples dropped by the transport, here and by the haptic thread, by reason.
  DropTable& drops() noexcept { return drops_; }
  /// Counts of the states that came, ahead of any conditioner; read once the transport has gone.
  const DeliveryCount& delivery() const noexcept { return delivery_; }

 private:
  struct Sender {
    PeerId peer = 0;
    std::uint64_t collects = 0;  // value of collects_ when `brought` began
    std::size_t brought = 0;     // samples since the haptic thread last collected
    std::int64_t received_ns = 0;
    LinkConditioner conditioner{LinkConditions{}};
  };

  // samples that wait until the haptic thread collects, once a millisecond
  static constexpr std::size_t kArriving = 4096;
  // one sender's share of them, so that no sender takes the others' room
  static constexpr std::size_t kShare = kArriving / 4;

  /// `from` is not 0: the transport drops samples without a sender.
  Sender& SenderOf(PeerId from, std::int64_t arrival_ns) noexcept;
  /// Returns a new place. Where all are taken, the sender that has been silent longest gives way.
  Sender& PlaceFor(PeerId from) noexcept;
  bool HasShare(Sender& sender) const noexcept;
  void TakeSwitches() noexcept;
  template <typename T>
  void Arrive(PeerId from, const T& sample, std::int64_t arrival_ns,
              SpscQueue<DueSample<T>>& ring) noexcept;
  template <typename T>
  void Move(SpscQueue<DueSample<T>>& ring, DueQueue<T>& waiting) noexcept;

  LinkConditions conditions_;
  PeerDirectory* directory_;
  PeerMap<Sender, 2 * kMaxPeers> senders_;
  std::atomic<std::uint64_t> collects_ = 0;
  SpscQueue<LinkSwitch> switches_{64};
  SpscQueue<DueSample<ObjectState>> arriving_states_;
  SpscQueue<DueSample<CouplingLinks>> arriving_links_;
  DueQueue<ObjectState> waiting_states_;
  DueQueue<CouplingLinks> waiting_links_;
  SpscQueue<Event> events_{1024};
  DropTable drops_;
  DeliveryCount delivery_;
};

}  // namespace tandem
