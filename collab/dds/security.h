#pragma once

#include <filesystem>

#include "collab/dds/dds_api.h"
#include "collab/dds/keys.h"

namespace tandem {

/// What a participant must be made with to take part in a secured session: Debian's plug-ins for
/// authentication, access control and cryptography, and a member's keys. Errors: the plug-ins are
/// not installed.
Result<Qos> SecureParticipantQos(const MemberKeys& keys);

/// What Cyclone's words for a refused participant or endpoint mean, for a person.
std::string ExplainRefusal(const std::string& said, const MemberKeys& keys);

}  // namespace tandem
