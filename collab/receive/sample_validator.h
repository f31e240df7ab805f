#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "collab/receive/sent_stamps.h"
#include "collab/session/drop_counts.h"
#include "collab/session/membership.h"
#include "collab/session/messages.h"
#include "collab/session/peer_map.h"

namespace tandem {

/// Admits the states and links that their sender may send, and counts the rest. A state is admitted
/// only under its sender's present claim on the body, and only once; an echo only if it is one of
/// our stamps. The holder of a shared body may go on to later epochs while its claim is on the way,
/// for claims take longer than states. Otherwise its link would pull towards an old pose. Samples
/// of peers that are not here pass uncounted, for no part of this peer uses them. Used by the
/// haptic thread alone; nothing allocates after construction.
class SampleValidator {
 public:
  /// `objects`: the moving bodies; `shared`: for each whether several may hold it. Empty: none.
  SampleValidator(PeerId self, const std::vector<std::uint32_t>& objects, DropTable& drops,
                  std::vector<bool> shared = {});

  void OnMembership(const MembershipChange& change) noexcept;
  /// Notes a stamp that goes out with this frame's states and links; stamps only grow.
  void NoteSent(std::int64_t sample_ns) noexcept { sent_.Add(sample_ns); }

  bool Accept(const ObjectState& state) noexcept;
  bool Accept(const CouplingLinks& links) noexcept;

 private:
  struct Instance {
    bool claimed = false;
    bool coupled = false;     // shared and in its sender's hand
    std::uint32_t epoch = 0;  // epoch of the claim
    std::uint32_t ahead = 0;  // epoch of the newest state if greater than the claim's, otherwise 0
    bool received = false;
    std::uint32_t seq = 0;  // number of the newest state under it
    bool linked = false;
    std::uint32_t links_seq = 0;
  };

  /// Returns the sender's instances: one for each of objects_, then one for links without object.
  std::span<Instance> InstancesOf(const PeerKey& sender) noexcept;
  /// Returns null where the object is no moving body.
  Instance* InstanceOf(const PeerKey& sender, ObjectId object) noexcept;
  bool Drops(PeerId peer, Drop reason) noexcept;  // returns false
  static bool CountsOn(const Instance& instance, const ObjectState& state) noexcept;

  PeerId self_;
  std::vector<std::uint32_t> objects_;
  std::vector<bool> shared_;
  DropTable* drops_;
  PeerSet<kMaxPeers> senders_;
  std::vector<Instance> instances_;  // by slot in senders_, then as InstancesOf() returns them
  StampRing<8192> sent_;             // at 1 kHz longer than any loop in use
};

}  // namespace tandem
