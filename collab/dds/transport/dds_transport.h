#pragma once

#include <memory>
#include <string>
#include <vector>

#include "collab/session/transport.h"
#include "engine/base/result.h"

namespace tandem {

class TransferEndpoint;

/// Says where, and as which peer, a program enters a session over DDS.
struct DdsOptions {
  std::string session;  // peers of other sessions are not seen or heard
  PeerId peer = 0;
  Role role = Role::kActive;
  std::uint32_t domain = 42;
  std::string interface;          // name; empty: Cyclone's choice. "lo": loopback, no multicast
  std::vector<ObjectId> objects;  // bodies that may be published; their DDS instances of state/1
                                  // are registered before the loop
  /// Addresses of other programs, HOST or HOST:PORT, IPv4. If there are any, no multicast is sent
  /// or received. An address without a port has the port `port`. If that is 0, the discovery ports
  /// of a machine's first programs are tried. With `peers`, `external_address` or `port` set,
  /// packets stay below the size that every path carries.
  std::vector<std::string> peers;
  std::string external_address;  // IPv4 address that others use for this machine behind address
                                 // translation
  std::uint16_t port = 0;        // UDP ports `port` and `port` + 1; 0: the domain's first free ones
  /// Folder of a member's keys. Only members whose keys the same authorities signed are met, and
  /// `peer` and `role` must be those of the keys. Empty: anyone on the network may listen and take
  /// part.
  std::string secure;
  /// This program's side of a transfer of the scene's files, which outlives the transport; null: no
  /// transfer. There is none behind a relay.
  TransferEndpoint* files = nullptr;
};

inline constexpr std::size_t kMaxSessionName = 128;  // bytes
inline constexpr std::uint32_t kMaxDomain = 230;     // the ports of the last domain end at 65159

/// HOST[:PORT] split into its parts; port 0: none was given.
struct PeerAddress {
  std::string host;
  std::uint16_t port = 0;
};
Result<PeerAddress> ParsePeerAddress(const std::string& text);

/// Joins a session. `inbox` must outlive the transport. Every program reads peer_info, viewer_info
/// and scene. An active peer also reads state/1, link/2 and event; a viewer reads view/1 and
/// nothing else. Errors (unknown interface, no free port, …) are in words for the user. The call
/// sets no clock and starts Cyclone's own threads and one control thread. A process is in one
/// session of a domain at a time. Leave() and destruction end all calls to the inbox, so neither
/// may be called from within one.
Result<std::unique_ptr<Transport>> JoinOverDds(const DdsOptions& options, Inbox& inbox);

}  // namespace tandem
