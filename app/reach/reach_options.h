#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "collab/dds/dds_transport.h"

namespace tandem {

/// How a session is reached: the options that all commands which join one have in common.
struct ReachOptions {
  std::uint32_t domain = 42;
  std::string interface;
  std::vector<std::string> peers;  // HOST or HOST:PORT
  std::string external_address;
  std::uint16_t port = 0;
  std::string secure;  // folder of keys; empty: plain
};

/// Adds --session: the name of one, not too long.
CLI::Option* AddSessionOption(CLI::App& command, std::string& session, const std::string& what);

/// Adds --interface, --domain, --peers, --external-address, --port and --secure.
void AddReachOptions(CLI::App& command, ReachOptions& options);

/// Puts them into what a transport is made with.
void ApplyReach(const ReachOptions& options, DdsOptions& dds);

/// Who one is: in a plain session a new random id, in a secured one the keys' id and name (into
/// `name`). Errors: the folder is no member's, or another role's.
Result<PeerId> Identify(const ReachOptions& options, Role role, std::string& name);

/// Whether others can listen, in a line for a person.
std::string SecurityOf(const ReachOptions& options, const std::string& session);

}  // namespace tandem
