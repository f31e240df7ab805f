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
};

/// Adds --interface, --domain, --peers, --external-address and --port.
void AddReachOptions(CLI::App& command, ReachOptions& options);

/// Puts them into what a transport is made with.
void ApplyReach(const ReachOptions& options, DdsOptions& dds);

}  // namespace tandem
