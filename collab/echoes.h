#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "collab/delay_meter.h"
#include "collab/membership.h"
#include "collab/messages.h"
#include "collab/sent_stamps.h"

namespace tandem {

/// The age of the loop to every active peer that holds something, whatever it is, while we do too:
/// its links carry the newest stamp of ours that it has seen. Where either hand is empty nothing of
/// one acts on the other and back, and there is no loop. Used by the haptic thread alone; nothing
/// allocates.
class Echoes {
 public:
  explicit Echoes(PeerId self) : self_(self) {}

  void OnMembership(const MembershipChange& change) noexcept;
  void OnState(const ObjectState& state) noexcept;
  void OnLinks(const CouplingLinks& links) noexcept;

  /// Once a frame, before the delays are used. `holding`: we have a body in hand.
  void Measure(std::int64_t now_ns, bool holding) noexcept;

  struct Loop {
    PeerId peer = 0;
    /// How old it is now, s: it grows while nothing comes back. 0: there is none, or nothing has
    /// come back yet.
    double age_s = 0;
    /// What gains must hold for, s: the worst of the past two seconds, or as long as we have waited
    /// for the first answer. 0: there is none.
    double peak_s = 0;
    double heard_s = -1;  // since a state of the peer came; -1: none has
  };
  /// Of all active peers, as measured last.
  std::span<const Loop> loops() const noexcept { return std::span(loops_).first(loop_count_); }

  /// Says what we have seen of those that `out` does not name yet; our own sample is of `now_ns`.
  void Append(std::int64_t now_ns, CouplingLinks& out) noexcept;

 private:
  struct Other {
    PeerId peer = 0;  // 0: a free place
    bool holds = false;
    std::int64_t sample_ns = 0;  // newest of its stamps
    std::int64_t since_ns = 0;   // when both hands had something; 0: one is empty
    std::int64_t ended_ns = 0;   // when that was last so
    std::int64_t echo_ns = 0;    // newest of ours that it has seen since; 0: none
    std::uint32_t seq = 0;
    bool heard = false;         // since the last frame
    std::int64_t heard_ns = 0;  // own time
    DelayMeter meter;
  };

  Other* Find(PeerId peer) noexcept;
  static Loop LoopTo(Other& other, std::int64_t now_ns, bool holding) noexcept;

  PeerId self_;
  std::array<Other, kMaxPeers> others_{};
  SentStamps sent_;
  std::size_t turn_ = 0;
  std::array<Loop, kMaxPeers> loops_{};
  std::size_t loop_count_ = 0;
};

}  // namespace tandem
