#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "collab/coupling/delay_meter.h"
#include "collab/receive/sent_stamps.h"
#include "collab/session/membership.h"
#include "collab/session/messages.h"
#include "collab/session/peer_map.h"

namespace tandem {

/// Measures the age of the loop to every active peer that holds a body, any body, while this peer
/// does too: the peer's links carry the newest own stamp that it has seen. Where either hand is
/// empty there is no loop, since neither peer acts on the other and back. Used by the haptic thread
/// alone; nothing allocates.
class RoundTripTracker {
 public:
  explicit RoundTripTracker(PeerId self) : self_(self) {}

  void OnMembership(const MembershipChange& change) noexcept;
  void OnState(const ObjectState& state) noexcept;
  void OnLinks(const CouplingLinks& links) noexcept;

  /// Measures once a frame, before the delays are used. `holding`: this peer has a body in hand.
  void Measure(std::int64_t now_ns, bool holding) noexcept;

  struct Loop {
    PeerId peer = 0;
    /// Present loop age, s: grows while no echo comes back. 0: there is no loop, or no echo has
    /// come back yet.
    double age_s = 0;
    /// Loop age that gains must hold for, s: the worst of the past two seconds, or the wait for the
    /// first echo so far. 0: there is none.
    double peak_s = 0;
    double received_s = -1;  // s since a state of the peer was received; -1: none has been
  };
  /// Loops to all active peers, as last measured.
  std::span<const Loop> loops() const noexcept { return std::span(loops_).first(loop_count_); }

  /// Adds echoes for the peers that `out` does not name yet; the own sample is that of `now_ns`.
  void Append(std::int64_t now_ns, CouplingLinks& out) noexcept;

 private:
  struct Other {
    PeerId peer = 0;
    bool holds = false;
    std::int64_t sample_ns = 0;  // newest stamp of the peer
    std::int64_t since_ns = 0;   // when both hands began to hold something; 0: one is empty
    std::int64_t ended_ns = 0;   // when both hands last held something
    std::int64_t echo_ns = 0;    // newest own stamp that the peer has seen in that time; 0: none
    std::uint32_t seq = 0;
    bool received = false;         // since the last frame
    std::int64_t received_ns = 0;  // own clock
    DelayMeter meter;
  };

  static Loop LoopTo(Other& other, std::int64_t now_ns, bool holding) noexcept;

  PeerId self_;
  PeerMap<Other, kMaxPeers> others_;
  SentStamps sent_;
  std::size_t turn_ = 0;
  std::array<Loop, kMaxPeers> loops_{};
  std::size_t loop_count_ = 0;
};

}  // namespace tandem
