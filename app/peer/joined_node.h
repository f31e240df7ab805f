#pragma once

#include "app/peer/joining.h"

namespace tandem {

/// Makes the node that simulates what was loaded, its device and its recorder. Otherwise it says
/// why not. Returns the exit code.
int MakeNode(const PeerArguments& arguments, Joining& joining);

}  // namespace tandem
