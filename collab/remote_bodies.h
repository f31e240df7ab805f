#pragma once

#include <array>
#include <vector>

#include "collab/membership.h"
#include "engine/world/step_inputs.h"
#include "engine/world/world_model.h"

namespace tandem {

/// Bodies that others hold and we do not (paper §6.1, type-1): each has a mirror here that follows
/// the newest received pose. How fast it may follow is the world's to say: by at most its share of
/// the travel limit, never in a jump. Used by the haptic thread alone; nothing allocates after
/// construction.
class RemoteBodies {
 public:
  explicit RemoteBodies(const WorldModel& model);

  void OnMembership(const MembershipChange& change) noexcept;
  void OnState(const ObjectState& state) noexcept;
  /// Others from whom at least one state has come.
  std::size_t heard() const noexcept;

  /// Says of every body but `held` (index into the moving bodies, or -1) who moves it. A free body
  /// that nobody holds is simulated here while no other active peer is in the session; with others
  /// it stands, since nobody's motion of it would be everybody's.
  void Prepare(int held, StepInputs& inputs) const noexcept;

 private:
  struct Instance {
    PeerId peer = 0;  // 0: a free place
    bool holds = false;
    bool heard = false;
    ObjectState state;
  };
  struct Body {
    ObjectId object = 0;
    bool free = false;
    std::array<Instance, kMaxPeers> instances{};
  };

  static Instance* Find(Body& body, PeerId peer) noexcept;

  std::vector<Body> bodies_;
  std::array<PeerId, kMaxPeers> present_{};  // other active peers; 0: a free place
};

}  // namespace tandem
