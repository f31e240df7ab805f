#pragma once

#include <cstdint>
#include <optional>
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

/// The last of the places, counted from 0, that the programs of a machine take in a domain.
inline constexpr std::uint32_t kLastProgramIndex = 60;

/// The UDP port that a program listens at for discovery, the `index`-th of its machine in a domain;
/// the next one is for data.
constexpr std::uint32_t DiscoveryPort(std::uint32_t domain, std::uint32_t index) {
  return 7400 + 250 * domain + 10 + 2 * index;
}

/// Why these options cannot work, in words; nothing: they can.
std::optional<Error> CheckOptions(const DdsOptions& options);

/// Makes the domain from the options alone; CYCLONEDDS_URI in the environment is not heeded, and
/// that is said. A process takes part in a domain once at a time.
Result<Entity> CreateDomain(const DdsOptions& options);

}  // namespace tandem
