#pragma once

#include <string>

#include "app/cli/findings.h"
#include "app/invite/invitation.h"
#include "app/reach/reach_options.h"

namespace tandem {

/// Says whether others beyond a router can reach this machine as it is started, as far as the
/// machine itself can tell. `beyond`: somebody is in another network.
void CheckOwnAddress(const ReachOptions& reach, bool beyond, Findings& findings);

/// Says whether this TCP port is free for `tandem invite`.
void CheckEnrolPort(std::uint16_t port, Findings& findings);

/// Says whose the keys are and how long they are good. Returns whether the doctor can look on with
/// them: with those of somebody who takes part it would be that one's twin.
bool CheckKeys(const ReachOptions& reach, Findings& findings);

/// Says whether a line is whole and good, and whether its inviter can be reached; uses nothing up.
/// Returns whether it could be read.
bool CheckInvitation(const std::string& line, Invitation& invitation, Findings& findings);

/// Says whether a scene is on this machine: the named one ("": none is named), and the line's.
void CheckScene(const std::string& named, const InvitedScene& invited, Findings& findings);

}  // namespace tandem
