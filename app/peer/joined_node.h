#pragma once

#include "app/peer/session_setup.h"

namespace tandem {

/// Makes the node that simulates what was loaded, its device and its recorder. Otherwise it says
/// why not. Returns the exit code.
int MakeNode(const PeerArguments& arguments, SessionSetup& setup);

}  // namespace tandem
