#pragma once

#include <array>
#include <cstdint>

#include "collab/delay_meter.h"
#include "collab/membership.h"
#include "collab/messages.h"
#include "collab/sent_stamps.h"

namespace tandem {

/// The age of the loop to every active peer, whatever it holds: its links carry the newest stamp
/// of ours that it has seen. Used by the haptic thread alone; nothing allocates.
class Echoes {
 public:
  explicit Echoes(PeerId self) : self_(self) {}

  void OnMembership(const MembershipChange& change) noexcept;
  void OnState(const ObjectState& state) noexcept;
  void OnLinks(const CouplingLinks& links) noexcept;

  /// Once a frame, before the delays are used.
  void Measure(std::int64_t now_ns) noexcept;
  /// The worst loop of the past two seconds over the peers that answer, s.
  double peak_loop_age_s() const noexcept;

  /// A peer's loop: how old it is now, s, and 0: not lately; how long ago a state of it came,
  /// -1: never did.
  struct Loop {
    PeerId peer = 0;
    double age_s = 0;
    double heard_s = 0;
  };
  /// Of all active peers; gives how many.
  std::size_t Loops(std::int64_t now_ns, std::array<Loop, kMaxPeers>& out) const noexcept;

  /// Says what we have seen of those that `out` does not name yet; our own sample is of `now_ns`.
  void Append(std::int64_t now_ns, CouplingLinks& out) noexcept;

 private:
  struct Other {
    PeerId peer = 0;             // 0: a free place
    std::int64_t sample_ns = 0;  // newest of its stamps
    std::int64_t echo_ns = 0;    // newest of ours that it holds
    std::uint32_t seq = 0;
    bool heard = false;         // since the last frame
    std::int64_t heard_ns = 0;  // own time
    bool fresh = false;
    DelayMeter meter;
  };

  Other* Find(PeerId peer) noexcept;

  PeerId self_;
  std::array<Other, kMaxPeers> others_{};
  SentStamps sent_;
  std::size_t turn_ = 0;
};

}  // namespace tandem
