#pragma once

#include <array>
#include <atomic>

#include "collab/delivery_count.h"
#include "collab/drop_counts.h"
#include "collab/due_queue.h"
#include "collab/link_conditioner.h"
#include "collab/peer_directory.h"
#include "collab/planted_faults.h"
#include "collab/transport.h"
#include "engine/realtime/spsc_queue.h"

namespace tandem {

/// A sample and when the link conditioner lets it through (the receiver's clock).
template <typename T>
struct DueSample {
  std::int64_t due_ns = 0;
  T sample;
};

/// Other conditions of the link from a peer (0: from everybody).
struct LinkSwitch {
  PeerId from = 0;
  LinkConditions conditions;
};

/// What an active peer hears: states and links go through the conditioner of their sender into
/// rings, stamped with the time they are due; the haptic thread takes them when that has come, in
/// that order. Membership goes to the directory.
class PeerInbox : public Inbox {
 public:
  /// Samples that may wait for their time: two seconds of delay from seven partners at 1 kHz, and
  /// some of them twice.
  static constexpr std::size_t kDefaultWaiting = 16384;

  /// `conditions`: of every sender until Switch() says otherwise; each has a random stream of its
  /// own.
  PeerInbox(const LinkConditions& conditions, PeerDirectory& directory,
            std::size_t waiting = kDefaultWaiting);

  void OnState(const ObjectState& state, std::int64_t arrival_ns) override;
  void OnLinks(const CouplingLinks& links, std::int64_t arrival_ns) override;
  void OnView(const ViewFrame&, std::int64_t) override {}
  void OnPeerInfo(const PeerInfo& info, std::int64_t) override { directory_->OnPeerInfo(info); }
  void OnPeerLeft(PeerId peer) override {
    if (!Planted(Fault::kLostGoodbye)) directory_->OnPeerLeft(peer);
  }
  void OnPeerLost(PeerId peer) override {
    if (!Planted(Fault::kLostLease)) directory_->OnPeerLost(peer);
  }
  void OnEvent(const Event& event, std::int64_t arrival_ns) override;
  void OnScene(const SceneManifest& manifest) override { directory_->OnScene(manifest); }
  void OnSceneWithdrawn(PeerId peer) override { directory_->OnSceneWithdrawn(peer); }
  void OnTwin(const PeerInfo& info) override { directory_->OnTwin(info); }
  void OnDropped(PeerId from, Drop reason) override { drops_.Count(from, reason); }

  /// Other conditions for what comes from `from` (0: from everybody, now and later), from its next
  /// sample on. False: too many switches are waiting. One thread, the control one.
  bool Switch(PeerId from, const LinkConditions& conditions) noexcept {
    return switches_.TryPush({from, conditions});
  }

  /// The haptic thread's ends. Collect() first, once a frame: it makes what has arrived visible.
  void Collect() noexcept;
  DueQueue<ObjectState>& states() noexcept { return waiting_states_; }
  DueQueue<CouplingLinks>& links() noexcept { return waiting_links_; }
  SpscQueue<Event>& events() noexcept { return events_; }
  SpscQueue<MembershipChange>& membership() noexcept { return directory_->changes(); }

  /// Samples that found no room and were dropped: the haptic thread stood still for seconds.
  std::uint64_t overflows() const noexcept {
    return drops_.Total()[static_cast<std::size_t>(Drop::kRingFull)];
  }
  /// What was dropped and why, by the transport, here and by the haptic thread.
  DropTable& drops() noexcept { return drops_; }
  /// Of the states that came, before any conditioner; once the transport has gone.
  const DeliveryCount& delivery() const noexcept { return delivery_; }

 private:
  struct Sender {
    PeerId peer = 0;  // 0: a free place
    std::uint64_t collects = 0;  // when `brought` began, by collects_
    std::size_t brought = 0;     // samples since the haptic thread last collected
    std::int64_t heard_ns = 0;
    LinkConditioner conditioner{LinkConditions{}};
  };

  // until the haptic thread collects, once a millisecond
  static constexpr std::size_t kArriving = 4096;
  // of that, what one sender may have, so that none takes the others' room
  static constexpr std::size_t kShare = kArriving / 4;

  Sender& SenderOf(PeerId from, std::int64_t arrival_ns) noexcept;
  bool HasShare(Sender& sender) const noexcept;
  void TakeSwitches() noexcept;
  template <typename T>
  void Arrive(PeerId from, const T& sample, std::int64_t arrival_ns,
              SpscQueue<DueSample<T>>& ring) noexcept;
  template <typename T>
  void Move(SpscQueue<DueSample<T>>& ring, DueQueue<T>& waiting) noexcept;

  LinkConditions conditions_;
  PeerDirectory* directory_;
  std::array<Sender, 2 * kMaxPeers> senders_;
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
