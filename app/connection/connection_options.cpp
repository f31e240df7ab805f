#include "app/connection/connection_options.h"

#include <random>

#include <arpa/inet.h>

#include "app/common/option_checks.h"
#include "collab/dds/security/keys.h"
#include "collab/dds/transport/domain.h"
#include "engine/base/text/clean_text.h"

namespace tandem {

CLI::Option* AddSessionOption(CLI::App& command, std::string& session, const std::string& what) {
  return command.add_option("--session", session, what)
      ->check(CLI::Validator(
          [](std::string& name) -> std::string {
            return WhyNoSessionName(name);
          },
          ""));
}

void AddConnectionOptions(CLI::App& command, ConnectionOptions& options) {
  command.add_option("--interface", options.interface,
                     "name of the network interface; default: all");
  command.add_option("--domain", options.domain, "DDS domain, a number")
      ->check(WholeNumberFrom(0, kMaxDomain));
  command
      .add_option("--peers", options.peers,
                  "addresses of the other peers beyond the local network, HOST[:PORT],…; switches "
                  "multicast off")
      ->delimiter(',')
      ->check(CLI::Validator(
          [](std::string& text) -> std::string {
            return ParsePeerAddress(text) ? "" : "'" + text + "' is not HOST or HOST:PORT (IPv4)";
          },
          "HOST[:PORT]"));
  command
      .add_option("--external-address", options.external_address,
                  "IPv4 address by which others reach this machine, behind a router")
      ->check(CLI::Validator(
          [](std::string& text) -> std::string {
            in_addr address{};
            return inet_pton(AF_INET, text.c_str(), &address) == 1
                       ? ""
                       : "'" + text + "' is not an IPv4 address";
          },
          "IPv4"));
  command
      .add_option("--port", options.port,
                  "UDP port at which others reach this program; it uses the next one too; default: "
                  "7410 + 250 x domain, or the next free pair")
      ->check(WholeNumberFrom(1024, 65534));
  command.add_option(
      "--secure", options.secure,
      "folder of keys, made by 'tandem keys'; the session then accepts members with keys alone");
}

void ApplyConnection(const ConnectionOptions& options, DdsOptions& dds) {
  dds.domain = options.domain;
  dds.interface = options.interface;
  dds.peers = options.peers;
  dds.external_address = options.external_address;
  dds.port = options.port;
  dds.secure = options.secure;
}

Result<PeerId> Identify(const ConnectionOptions& options, Role role, std::string& name) {
  name = CleanText(name);
  if (options.secure.empty()) {
    std::random_device random;
    PeerId id = 0;
    while (id == 0) id = static_cast<PeerId>(random()) << 32U | random();
    return id;
  }
  const Result<MemberKeys> keys = LoadMemberKeys(options.secure);
  if (!keys) return keys.error();
  if (keys->relay) {
    return Error{options.secure +
                 ": these are keys for the other side of a relay (--audience-secure)"};
  }
  if (keys->role != role) {
    return Error{options.secure + ": these are the keys of a " +
                 (role == Role::kViewer ? "peer; to look on, use keys of a viewer"
                                        : "viewer; to take part, use keys of a peer")};
  }
  name = CleanText(keys->name);
  return keys->peer;
}

std::string SecurityOf(const ConnectionOptions& options, const std::string& session) {
  if (!options.secure.empty()) {
    const Result<MemberKeys> keys = LoadMemberKeys(options.secure);
    const std::string ending = keys ? ExpiryWarning(*keys) : std::string();
    return "session " + session + " is secured: members only, signed and encrypted" +
           (ending.empty() ? "" : "; " + ending);
  }
  return "session " + session +
         " is plain: everybody who reaches this network can listen and take part (--secure "
         "prevents that)";
}

}  // namespace tandem
