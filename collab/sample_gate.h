#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "collab/drop_counts.h"
#include "collab/membership.h"
#include "collab/messages.h"
#include "collab/sent_stamps.h"

namespace tandem {

/// Lets through what others may say of bodies and loops, and counts the rest: a state counts only
/// under its sender's present claim on the body, and each only once; an echo only if it is a stamp
/// of ours. Who holds a shared body may count on while its claim is on the way, for claims take
/// longer than states, and a partner that is not heard meanwhile would pull at where it was. What
/// comes from those who are not here passes uncounted, for nobody takes it. Used by
/// the haptic thread alone; nothing allocates after construction.
class SampleGate {
 public:
  /// `objects`: the bodies that move; `shared`: which of them several may hold. Empty: none.
  SampleGate(PeerId self, const std::vector<std::uint32_t>& objects, DropTable& drops,
             std::vector<bool> shared = {});

  void OnMembership(const MembershipChange& change) noexcept;
  /// A stamp that goes out with this frame's states and links; they only grow.
  void NoteSent(std::int64_t sample_ns) noexcept { sent_.Add(sample_ns); }

  bool Admit(const ObjectState& state) noexcept;
  bool Admit(const CouplingLinks& links) noexcept;

 private:
  struct Instance {
    bool claimed = false;
    bool coupled = false;     // shared, and in its sender's hand
    std::uint32_t epoch = 0;  // of the claim
    std::uint32_t ahead = 0;  // of the newest state, where that is beyond the claim's; 0: it is not
    bool heard = false;
    std::uint32_t seq = 0;  // of the newest state under it
    bool linked = false;
    std::uint32_t links_seq = 0;
  };
  struct Sender {
    PeerId peer = 0;                  // 0: a free place
    std::vector<Instance> instances;  // as objects_, and one for links without an object
  };

  Sender* Find(PeerId peer) noexcept;
  Instance* InstanceOf(Sender& sender, ObjectId object) noexcept;  // null: no body that moves
  bool Drops(PeerId peer, Drop reason) noexcept;                   // false, for returning
  static bool CountsOn(const Instance& instance, const ObjectState& state) noexcept;

  PeerId self_;
  std::vector<std::uint32_t> objects_;
  std::vector<bool> shared_;
  DropTable* drops_;
  std::array<Sender, kMaxPeers> senders_;
  StampRing<8192> sent_;  // at 1 kHz longer than any loop that is used
};

}  // namespace tandem
