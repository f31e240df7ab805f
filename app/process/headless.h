#pragma once

#include "app/connection/hand_request.h"

namespace tandem {

/// Starts a controller as a window would, prints what the window would show first, and ends the
/// controller. Returns the exit code, which is the controller's once that has ended.
int ShowHeadless(const HandRequest& request, bool json);

/// Returns whether the controller of a window answers on this machine; waits two seconds at most.
bool ControllerAnswers(const HandRequest& request);

/// Ends the controller of a window that is gone, if it still runs.
void EndControllerOf(const HandRequest& request);

}  // namespace tandem
