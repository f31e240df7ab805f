#include "app/doctor/doctor_connectivity.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <optional>
#include <vector>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "app/common/console.h"
#include "app/common/scene_files.h"
#include "app/connection/scene_search.h"
#include "app/invite/enrolment_client.h"
#include "collab/dds/diagnostics/reachability.h"
#include "collab/dds/security/keys.h"
#include "collab/session/scene_agreement.h"
#include "engine/base/text/clean_text.h"
#include "engine/base/text/hex.h"

namespace tandem {
namespace {

/// Returns whether an address means nothing on the Internet: an address of a private network (RFC
/// 1918), of a provider's own (RFC 6598), of a link or of the machine itself.
bool IsPrivateAddress(const std::string& text) {
  in_addr address{};
  if (inet_pton(AF_INET, text.c_str(), &address) != 1) return false;
  struct Network {
    std::uint32_t base;
    int bits;
  };
  constexpr std::array kNetworks{Network{0x0a000000, 8},  Network{0xac100000, 12},
                                 Network{0xc0a80000, 16}, Network{0x64400000, 10},
                                 Network{0xa9fe0000, 16}, Network{0x7f000000, 8}};
  const std::uint32_t bits = ntohl(address.s_addr);
  return std::ranges::any_of(kNetworks, [bits](const Network& network) {
    return (bits ^ network.base) >> (32 - network.bits) == 0;
  });
}

std::string Until(std::time_t end) {
  return TimeForAPerson(end, std::time(nullptr));
}

}  // namespace

void CheckOwnAddress(const ConnectionOptions& connection, bool beyond, Findings& findings) {
  std::string own;
  bool all_private = true;
  bool has_external = false;
  for (const InterfaceFacts& interface : UsableInterfaces()) {
    if (interface.loopback) continue;
    own += (own.empty() ? "" : ", ") + interface.address;
    all_private = all_private && IsPrivateAddress(interface.address);
    has_external = has_external || interface.address == connection.external_address;
  }
  const std::string what = "own address";
  const std::string ports = connection.port == 0 ? "N and N + 1"
                                                 : std::to_string(connection.port) + " and " +
                                                       std::to_string(connection.port + 1);
  if (!connection.external_address.empty()) {
    if (IsPrivateAddress(connection.external_address)) {
      findings.Add(Finding::kWarning, what,
                   connection.external_address + " is an address of a private network",
                   "fine within that network or a VPN; over the Internet, give the router's public "
                   "address, which the router's own pages show");
    } else if (connection.port == 0 && !has_external) {
      findings.Add(Finding::kWarning, what, connection.external_address + ", but no --port",
                   "a router forwards fixed ports: give --port N, and forward UDP N and N + 1 to "
                   "this machine, and TCP N for 'tandem invite'");
    } else {
      findings.Add(Finding::kGood, what,
                   connection.external_address +
                       (has_external ? " is this machine's own"
                                     : "; the router must forward UDP " + ports + " to " + own));
    }
    return;
  }
  if (!beyond || own.empty()) return;
  if (!all_private) {
    findings.Add(Finding::kGood, what, own);
    return;
  }
  findings.Add(Finding::kWarning, what, own + ": private networks only",
               "fine within one network or a VPN; over the Internet, forward UDP N and N + 1 at "
               "the router to this machine, and give --external-address A --port N");
}

void CheckEnrolPort(std::uint16_t port, Findings& findings) {
  const int listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int yes = 1;
  setsockopt(listener, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  const bool free = bind(listener, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0 &&
                    listen(listener, 1) == 0;
  const int fault = errno;
  close(listener);
  const std::string what = "port for invitations";
  if (free) {
    findings.Add(Finding::kGood, what, "TCP " + std::to_string(port) + " is free");
  } else {
    findings.Add(Finding::kWarning, what,
                 "TCP " + std::to_string(port) + ": " + std::strerror(fault),
                 "fine if 'tandem invite' uses it; otherwise give another port with --enrol-port");
  }
}

bool CheckKeys(const ConnectionOptions& connection, Findings& findings) {
  if (connection.secure.empty()) return true;
  const Result<MemberKeys> keys = LoadMemberKeys(connection.secure);
  if (!keys) {
    findings.Add(Finding::kBad, "keys", keys.error().what);
    return false;
  }
  const std::string ending = ExpiryWarning(*keys);
  const bool viewer = keys->role == Role::kViewer && !keys->relay;
  const std::string whose = keys->name + ", who " +
                            (keys->relay ? "relays"
                             : viewer    ? "looks on"
                                         : "takes part") +
                            "; good until " + Until(keys->not_after);
  findings.Add(ending.empty() ? Finding::kGood : Finding::kWarning, "keys", whose,
               ending.empty() ? "" : "they end soon: make new keys with 'tandem keys'");
  return viewer;
}

bool CheckInvitation(const std::string& line, Invitation& invitation, Findings& findings) {
  const Result<Invitation> read = ReadInvitation(line, LineForm::kWholeOrPublic);
  if (!read) {
    findings.Add(Finding::kBad, "invitation", read.error().what);
    return false;
  }
  invitation = *read;
  findings.Add(Finding::kGood, "invitation",
               std::string(invitation.secured ? "secured" : "plain") + " session " +
                   CleanText(invitation.session) + ", to " +
                   (invitation.role == Role::kViewer ? "look on" : "take part"));
  if (!invitation.secured) return true;
  const InviterFacts facts = ProbeInviter(invitation);
  if (facts.is_the_inviter) {
    findings.Add(Finding::kGood, "inviter",
                 facts.what + "; good until " + Until(invitation.enrolment.until));
    return true;
  }
  const bool over = std::time(nullptr) >= invitation.enrolment.until;
  findings.Add(
      Finding::kBad, "inviter", facts.what,
      over ? "ask the inviter for a new line"
           : "ask the inviter: does 'tandem invite' still run? Do router and firewall let TCP " +
                 std::to_string(invitation.enrolment.port) +
                 " through to it? Otherwise exchange files: tandem keys request --help");
  return true;
}

void CheckScene(const std::string& named, const InvitedScene& invited, Findings& findings) {
  if (!named.empty()) {
    const Result<Scene> scene = LoadNamedScene(named);
    const Result<SceneHash> hash = scene ? HashScene(*scene) : Result<SceneHash>(scene.error());
    if (!hash) {
      findings.Add(Finding::kBad, "scene", hash.error().what);
      return;
    }
    const bool other = invited.digest && *invited.digest != hash->digest;
    findings.Add(other ? Finding::kBad : Finding::kGood, "scene",
                 scene->file.string() + ", digest " + HexOfBytes(hash->digest),
                 other ? "the invitation is to another scene, " + HexOfBytes(*invited.digest) +
                             ": leave --scene out, or ask for the invitation's files"
                       : "");
    return;
  }
  if (!invited.digest) return;
  const auto file = FindScene({.digest = invited.digest,
                               .file = invited.file,
                               .bodies = invited.bodies,
                               .open_told = false,
                               .fetched = FetchedScenes({})},
                              FoldersWithScenes());
  if (file) {
    findings.Add(Finding::kGood, "scene", file->string() + ", the invitation's scene");
  } else {
    findings.Add(Finding::kWarning, "scene", CleanText(invited.file) + " is not on this machine",
                 "'tandem join' asks you, and then fetches it from the session; or get its files, "
                 "and name them with --scene");
  }
}

}  // namespace tandem
