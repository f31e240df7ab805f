#pragma once

#include <cstdint>
#include <memory>

#include "app/connection/connection_options.h"
#include "app/invite/invitation.h"
#include "collab/session/sessions_nearby.h"

namespace tandem {

/// Finds where an invitation's session is. It listens for the session from its construction on,
/// while the owner does other things.
class InviterSearch {
 public:
  /// Puts the session's domain into `connection`.
  InviterSearch(Invitation invitation, ConnectionOptions& connection);

  /// Puts the line's hosts into `connection`, unless it names others already or the session is
  /// announced on this network. Waits for the announcement until two seconds after the
  /// construction.
  void End(ConnectionOptions& connection);

 private:
  const Invitation invitation_;
  std::unique_ptr<SessionsNearby> nearby_;  // null: there is nothing to listen for
  std::int64_t until_ns_ = 0;
};

/// Does the same at once, for an owner that has nothing else to do meanwhile.
void ReachInviter(const Invitation& invitation, ConnectionOptions& connection);

}  // namespace tandem
