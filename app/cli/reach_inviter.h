#pragma once

#include "app/invite/invitation.h"
#include "app/reach/reach_options.h"

namespace tandem {

/// Puts into `reach` where an invitation's session is: its domain, and unless others are named in
/// it already, nothing more where the session is announced on this network, else the line's hosts.
/// Listens for two seconds at the most.
void ReachInviter(const Invitation& invitation, ReachOptions& reach);

}  // namespace tandem
