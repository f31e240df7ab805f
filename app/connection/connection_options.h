#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "collab/dds/transport/dds_transport.h"

namespace tandem {

/// The options that say how to reach a session, common to all commands that join one.
struct ConnectionOptions {
  std::uint32_t domain = 42;
  std::string interface;
  std::vector<std::string> peers;  // HOST or HOST:PORT
  std::string external_address;
  std::uint16_t port = 0;
  std::string secure;  // folder of keys; empty: a plain session
};

/// Adds --session, and checks that the name is not too long.
CLI::Option* AddSessionOption(CLI::App& command, std::string& session, const std::string& what);

/// Adds --interface, --domain, --peers, --external-address, --port and --secure.
void AddConnectionOptions(CLI::App& command, ConnectionOptions& options);

/// Copies the options into those of a transport.
void ApplyConnection(const ConnectionOptions& options, DdsOptions& dds);

/// Returns the id to join with: a random id in a plain session, the keys' id in a secured one,
/// whose name it writes into `name`. Errors: the folder is not a member's, or is for another role.
Result<PeerId> Identify(const ConnectionOptions& options, Role role, std::string& name);

/// Returns a line for a person that says whether others can listen.
std::string SecurityOf(const ConnectionOptions& options, const std::string& session);

}  // namespace tandem
