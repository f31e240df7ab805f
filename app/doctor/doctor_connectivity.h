#pragma once

#include <string>

#include "app/connection/connection_options.h"
#include "app/doctor/findings.h"
#include "app/invite/invitation.h"

namespace tandem {

/// Says whether programs beyond a router can reach this machine as it is started, as far as the
/// machine itself can tell. `beyond`: a peer is in another network.
void CheckOwnAddress(const ConnectionOptions& connection, bool beyond, Findings& findings);

/// Says whether this TCP port is free for `tandem invite`.
void CheckEnrolPort(std::uint16_t port, Findings& findings);

/// Says whose the keys are and when they expire. Returns whether the doctor can look on with them.
/// With the keys of an active member it would be that member's twin.
bool CheckKeys(const ConnectionOptions& connection, Findings& findings);

/// Says whether an invitation's line is whole and good, and whether its inviter can be reached. It
/// does not use up the line. Returns whether the line could be read.
bool CheckInvitation(const std::string& line, Invitation& invitation, Findings& findings);

/// Says whether a scene is on this machine. The scene is `named` and is compared with the invited
/// one, or it is the invited one if `named` is empty.
void CheckScene(const std::string& named, const InvitedScene& invited, Findings& findings);

}  // namespace tandem
