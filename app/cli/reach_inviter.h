#pragma once

#include <cstdint>
#include <memory>

#include "app/invite/invitation.h"
#include "app/reach/reach_options.h"
#include "collab/sessions_nearby.h"

namespace tandem {

/// Finds where an invitation's session is. Listens for it from the construction on, while the owner
/// does other things.
class InviterSearch {
 public:
  /// Puts the session's domain into `reach`.
  InviterSearch(Invitation invitation, ReachOptions& reach);

  /// Puts the line's hosts into `reach`, unless others are named in it already or the session is
  /// announced on this network. Waits until it is, or until two seconds after the construction.
  void End(ReachOptions& reach);

 private:
  const Invitation invitation_;
  std::unique_ptr<SessionsNearby> nearby_;  // null: there is nothing to listen for
  std::int64_t until_ns_ = 0;
};

/// The same at once, for an owner who has nothing else to do meanwhile.
void ReachInviter(const Invitation& invitation, ReachOptions& reach);

}  // namespace tandem
