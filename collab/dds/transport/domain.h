#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "collab/dds/cyclone/dds_api.h"
#include "collab/dds/transport/dds_transport.h"

namespace tandem {

/// Returns the Cyclone configuration of a session: discovery tag, leases, interface, receive
/// thread.
std::string DomainXml(const DdsOptions& options, bool real_time_receive);

/// Returns the session's name in a form that no other use of the domain has: "tandem/NAME", with
/// %XX for all but letters, digits, '.', '_' and '-'. Neither XML nor Cyclone's ${} changes this
/// form.
std::string DiscoveryTag(const std::string& session);

/// The last of the places, counted from 0, that a machine's programs take in a domain.
inline constexpr std::uint32_t kLastProgramIndex = 60;

/// Returns the UDP port at which a program listens for discovery, the `index`-th program of its
/// machine in a domain. The next port is for data.
constexpr std::uint32_t DiscoveryPort(std::uint32_t domain, std::uint32_t index) {
  return 7400 + 250 * domain + 10 + 2 * index;
}

/// Returns why a session cannot have this name; empty: it can. A name is plain text, since it goes
/// to terminals.
std::string WhyNoSessionName(const std::string& name);

/// Returns why these options cannot work, in words, or nothing if they can.
std::optional<Error> CheckOptions(const DdsOptions& options);

/// Makes the domain from the options alone. It ignores CYCLONEDDS_URI in the environment and says
/// so. A process takes part in a domain once at a time. `proves_members`: its members prove their
/// keys, and the caller tells the domain's networks which ones are met.
Result<Entity> CreateDomain(const DdsOptions& options, bool proves_members = false);

}  // namespace tandem
