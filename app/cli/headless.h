#pragma once

#include "app/reach/hand_request.h"

namespace tandem {

/// Starts a controller as a window would, prints what the window would show first, ends the
/// controller. Returns the exit code; that of a controller that ended by itself.
int ShowHeadless(const HandRequest& request, bool json);

}  // namespace tandem
