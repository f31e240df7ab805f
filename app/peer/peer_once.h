#pragma once

#include "app/peer/peer_control.h"
#include "app/peer/peer_options.h"

namespace tandem {

/// Takes part in a session once. Returns the exit code or kJoinAgain. `control`: null: the peer is
/// no controller. `may_join_again`: other force parameters, offered at the same time, still count.
int RunOnce(PeerArguments& arguments, PeerControl* control, bool may_join_again);

}  // namespace tandem
