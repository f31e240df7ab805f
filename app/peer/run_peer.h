#pragma once

#include "app/peer/peer_options.h"

namespace tandem {

/// Takes part in a session, or looks on in the role of a viewer, until a signal or an order ends
/// it. Says what went wrong. Returns the exit code.
int RunPeer(PeerArguments& arguments);

}  // namespace tandem
