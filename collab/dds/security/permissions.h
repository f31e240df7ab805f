#pragma once

#include <ctime>
#include <string>

#include "collab/session/messages.h"

namespace tandem {

/// Returns the subject of a member's certificate, as DDS Security writes it. The id is part of it,
/// so a certificate belongs to one peer, whatever its name.
std::string SubjectOf(const std::string& name, PeerId peer);

/// Returns the rules for all members of a secured session (DDS Security §9.4.1.2). Nobody takes
/// part without a certificate, and discovery is encrypted. All packets are signed, so that each
/// receiver knows which member sent them. All samples are encrypted with keys that only matched
/// readers get.
std::string GovernanceXml();

/// Returns what one member may do (§9.4.1.3), and nothing else. A peer publishes in its own
/// partitions peer.<id>, view.<id> and scene.<id>, and its presence in peer.<id>.<name>. A viewer
/// publishes its presence in viewer.<id>.<name>, and of pose topics it reads view/1 only. All
/// members publish and read review/* (notes, cameras, a viewer's requests for files). Peers publish
/// file/* (files of scenes), which all members read. The patterns leave room for later topics, so
/// that keys need not change.
std::string PermissionsXml(const std::string& name, PeerId peer, Role role, std::time_t from,
                           std::time_t until);

/// Returns what a relay may do among its audience: publish as each peer that it shows. A peer has
/// nothing to gain there, so these permissions are for a separate session.
std::string RelayPermissionsXml(const std::string& name, PeerId peer, std::time_t from,
                                std::time_t until);

}  // namespace tandem
