#include "app/cli/reach_options.h"

namespace tandem {

void AddReachOptions(CLI::App& command, ReachOptions& options) {
  command.add_option("--interface", options.interface, "network interface by name");
  command.add_option("--domain", options.domain, "DDS domain")->check(CLI::Range(0, 230));
  command
      .add_option("--peers", options.peers,
                  "where the others are, beyond the local network: HOST[:PORT],…; no multicast")
      ->delimiter(',');
  command.add_option("--external-address", options.external_address,
                     "the IPv4 address that others reach this machine by, behind a router");
  command
      .add_option("--port", options.port,
                  "UDP port to be reached at, and the next one; default: 7410 + 250 x domain, or "
                  "the next that is free")
      ->check(CLI::Range(1024, 65534));
}

void ApplyReach(const ReachOptions& options, DdsOptions& dds) {
  dds.domain = options.domain;
  dds.interface = options.interface;
  dds.peers = options.peers;
  dds.external_address = options.external_address;
  dds.port = options.port;
}

}  // namespace tandem
