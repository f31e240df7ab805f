#pragma once

#include <ctime>
#include <string>

#include "collab/messages.h"

namespace tandem {

/// The subject of a member's certificate, as DDS Security writes it. The id is part of it: a
/// certificate is one peer's, whatever its name.
std::string SubjectOf(const std::string& name, PeerId peer);

/// What all members of a secured session must keep to (DDS Security §9.4.1.2): nobody without a
/// certificate, discovery encrypted, all packets signed, all samples encrypted with keys that only
/// matched readers get.
std::string GovernanceXml();

/// What one member may do (§9.4.1.3), and nothing else. A peer publishes in its own partitions
/// peer.<id> and view.<id>, and offers scenes; a viewer publishes its peer_info, and of pose topics
/// it reads view/1 only.
std::string PermissionsXml(const std::string& name, PeerId peer, Role role, std::time_t from,
                           std::time_t until);

/// What a relay may do among those who look on behind it: say what each peer that it shows says.
/// Nothing there is worth having for a peer, so these are of a session of their own.
std::string RelayPermissionsXml(const std::string& name, PeerId peer, std::time_t from,
                                std::time_t until);

}  // namespace tandem
