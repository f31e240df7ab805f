#pragma once

#include <filesystem>

#include "collab/dds/cyclone/dds_api.h"
#include "collab/dds/security/keys.h"

namespace tandem {

/// Returns the quality of service of a participant in a secured session: Debian's plug-ins for
/// authentication, access control and cryptography, and a member's keys. Error: the plug-ins are
/// not installed.
Result<Qos> SecureParticipantQos(const MemberKeys& keys);

/// Returns the meaning for a person of Cyclone's message about a refused participant or endpoint.
std::string ExplainRefusal(const std::string& output, const MemberKeys& keys);

}  // namespace tandem
