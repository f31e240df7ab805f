#pragma once

#include <atomic>

#include "collab/link_conditioner.h"
#include "collab/peer_directory.h"
#include "collab/transport.h"
#include "engine/realtime/spsc_queue.h"

namespace tandem {

/// A sample and when the link conditioner lets it through (the receiver's clock).
template <typename T>
struct DueSample {
  std::int64_t due_ns = 0;
  T sample;
};

/// What an active peer hears: states and links go through the link conditioner into rings, stamped
/// with the time they are due, and the haptic thread takes them when that has come; membership goes
/// to the directory.
class PeerInbox : public Inbox {
 public:
  PeerInbox(const LinkConditions& conditions, PeerDirectory& directory);

  void OnState(const ObjectState& state, std::int64_t arrival_ns) override;
  void OnLinks(const CouplingLinks& links, std::int64_t arrival_ns) override;
  void OnView(const ViewFrame&, std::int64_t) override {}
  void OnPeerInfo(const PeerInfo& info, std::int64_t) override { directory_->OnPeerInfo(info); }
  void OnPeerLeft(PeerId peer) override { directory_->OnPeerLeft(peer); }
  void OnPeerLost(PeerId peer) override { directory_->OnPeerLost(peer); }
  void OnEvent(const Event& event, std::int64_t arrival_ns) override;
  void OnScene(const SceneManifest&) override {}

  /// The haptic thread's ends: oldest first.
  SpscQueue<DueSample<ObjectState>>& states() noexcept { return states_; }
  SpscQueue<DueSample<CouplingLinks>>& links() noexcept { return links_; }
  SpscQueue<Event>& events() noexcept { return events_; }
  SpscQueue<MembershipChange>& membership() noexcept { return directory_->changes(); }

  /// Samples that found a ring full and were dropped: the haptic thread stood still for seconds.
  std::uint64_t overflows() const noexcept { return overflows_.load(std::memory_order_relaxed); }

 private:
  // two seconds of delay from four partners at 1 kHz
  static constexpr std::size_t kCapacity = 8192;

  LinkConditioner conditioner_;
  PeerDirectory* directory_;
  SpscQueue<DueSample<ObjectState>> states_{kCapacity};
  SpscQueue<DueSample<CouplingLinks>> links_{kCapacity};
  SpscQueue<Event> events_{1024};
  std::atomic<std::uint64_t> overflows_{0};
};

}  // namespace tandem
