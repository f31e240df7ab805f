#pragma once

#include <string>

#include "collab/dds/dds_api.h"
#include "collab/dds/dds_transport.h"

namespace tandem {

/// The Cyclone configuration of a session: its discovery tag, leases, interface, receive thread.
std::string DomainXml(const DdsOptions& options, bool real_time_receive);

/// The session's name where others of the same domain cannot take it for theirs: "tandem/NAME",
/// whatever is not a letter, digit, '.', '_' or '-' as %XX. XML and Cyclone's own ${} leave it as
/// it is.
std::string DiscoveryTag(const std::string& session);

/// Makes the domain from the options alone; CYCLONEDDS_URI in the environment is not heeded, and
/// that is said. A process takes part in a domain once at a time.
Result<Entity> CreateDomain(const DdsOptions& options);

}  // namespace tandem
