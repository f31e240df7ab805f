#pragma once

#include <memory>
#include <string>
#include <vector>

#include "collab/transport.h"
#include "engine/base/result.h"

namespace tandem {

class FileParty;

/// Where and as whom a program enters a session over DDS.
struct DdsOptions {
  std::string session;  // peers of other sessions are neither seen nor heard
  PeerId peer = 0;
  Role role = Role::kActive;
  std::uint32_t domain = 42;
  std::string interface;          // by name; empty: Cyclone's choice. "lo": loopback, no multicast
  std::vector<ObjectId> objects;  // that may be published: their DDS instances of state/1 are
                                  // registered before the loop
  /// Where others are, HOST or HOST:PORT, IPv4: then no multicast is sent or heard. Without a port
  /// all those of a machine's first programs are tried. With any of these three, packets are kept
  /// below what every path carries.
  std::vector<std::string> peers;
  std::string external_address;  // behind address translation: the IPv4 address that others use
  std::uint16_t port = 0;        // UDP ports `port` and `port` + 1; 0: the domain's first free ones
  /// Folder of a member's keys: only those whose keys the same authorities signed are met, and
  /// `peer` and `role` must be the keys'. Empty: anyone on the network may listen and take part.
  std::string secure;
  /// Side of a transfer of the scene's files, which outlives the transport; null: none. Behind a
  /// relay there is none.
  FileParty* files = nullptr;
};

inline constexpr std::size_t kMaxSessionName = 128;  // bytes
inline constexpr std::uint32_t kMaxDomain = 230;     // its ports end at 65159

/// HOST[:PORT] taken apart; port 0: none was given.
struct PeerAddress {
  std::string host;
  std::uint16_t port = 0;
};
Result<PeerAddress> ParsePeerAddress(const std::string& text);

/// Joins a session. `inbox` must outlive the transport. All read peer_info, viewer_info and scene;
/// an active peer also state/1, link/2 and event, a viewer view/1 and nothing else. Errors (unknown interface, no free port, …) are said in words. Sets no clock,
/// starts Cyclone's own threads and one control thread. A process is in one session of a domain at
/// a time. Leave() and destruction end all calls to the inbox, and so must not be called from
/// within one.
Result<std::unique_ptr<Transport>> JoinOverDds(const DdsOptions& options, Inbox& inbox);

}  // namespace tandem
