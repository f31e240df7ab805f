#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <memory>
#include <mutex>

#include <nlohmann/json.hpp>

#include "app/cli/commands.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/stop_signal.h"
#include "app/connection/connection_options.h"
#include "app/doctor/doctor_connectivity.h"
#include "app/doctor/doctor_display.h"
#include "app/doctor/doctor_realtime.h"
#include "app/doctor/doctor_trace.h"
#include "app/doctor/findings.h"
#include "app/invite/given_line.h"
#include "app/join/discover_sessions.h"
#include "app/join/reach_inviter.h"
#include "collab/dds/cyclone/socket_drops.h"
#include "collab/dds/diagnostics/reachability.h"
#include "collab/dds/transport/domain.h"
#include "engine/base/text/clean_text.h"
#include "engine/base/text/json_text.h"
#include "engine/realtime/clock.h"

namespace tandem {
namespace {

constexpr std::uint32_t kPortsLookedAt = 8;  // ports of as many programs on this machine
constexpr std::uint16_t kAnswerPort = 7399;  // beside DDS's own, which begin at 7400
constexpr int kLeastPayload = 1400;          // size that a session's packets need
constexpr double kAnnouncedWithin = 2;       // s
constexpr std::int64_t kDoctorListensNs = 2'000'000'000;  // for the members of the session

struct DoctorArguments {
  ConnectionOptions connection;
  std::string session;
  std::string invitation;
  std::string scene;
  std::uint16_t enrol_port = 0;
  LineArguments line;
  bool answer = false;
  bool json = false;
};

/// Collects the names of the programs that answer in a session.
class Listener final : public Inbox {
 public:
  void OnState(const ObjectState&, std::int64_t) override {}
  void OnLinks(const CouplingLinks&, std::int64_t) override {}
  void OnView(const ViewFrame&, std::int64_t) override {}
  void OnPeerInfo(const PeerInfo& info, std::int64_t) override {
    const std::scoped_lock lock(mutex_);
    names_[info.peer] = info.name;
  }
  void OnPeerLeft(PeerId) override {}
  void OnPeerLost(PeerId) override {}
  void OnEvent(const Event&, std::int64_t) override {}
  void OnScene(const SceneManifest&) override {}

  std::string Names() const {
    const std::scoped_lock lock(mutex_);
    std::string all;
    for (const auto& [peer, name] : names_) all += (all.empty() ? "" : ", ") + name;
    return all;
  }

 private:
  mutable std::mutex mutex_;
  std::map<PeerId, std::string> names_;
};

void CheckInterfaces(const DoctorArguments& arguments, Findings& findings) {
  bool beyond = false;
  const bool needs_multicast = arguments.connection.peers.empty();
  for (const InterfaceFacts& interface : UsableInterfaces()) {
    const std::string& wanted = arguments.connection.interface;
    if (!wanted.empty() && wanted != interface.name) continue;
    const std::string what = "interface " + interface.name;
    if (!interface.carrier) {
      findings.Add(wanted.empty() ? Finding::kGood : Finding::kWarning, what,
                   interface.address + ", no carrier: sessions pass it over",
                   wanted.empty() ? "" : "connect it, or leave --interface out");
      continue;
    }
    beyond = beyond || !interface.loopback;
    const std::string found =
        interface.address + ", packets of " + std::to_string(interface.mtu) + " bytes";
    if (interface.loopback || !needs_multicast) {
      findings.Add(Finding::kGood, what, found);
    } else if (!interface.multicast || !MulticastWorks(interface)) {
      findings.Add(Finding::kWarning, what, found + ", no multicast",
                   "name the other machines: --peers HOST[:PORT],…");
    } else {
      findings.Add(Finding::kGood, what, found + ", multicast");
    }
  }
  if (!beyond && arguments.connection.interface != "lo") {
    findings.Add(Finding::kWarning, "interfaces", "only this machine's own",
                 "connect to a network; to stay on this machine, give --interface lo");
  }
}

void CheckPorts(const DoctorArguments& arguments, Findings& findings) {
  if (const std::uint16_t port = arguments.connection.port;
      port != 0) {  // others are refused already
    findings.Add(Finding::kGood, "ports",
                 "UDP " + std::to_string(port) + " and " + std::to_string(port + 1) + " are free");
    return;
  }
  const std::vector<std::uint16_t> taken = PortsTaken(arguments.connection.domain, kPortsLookedAt);
  const std::uint32_t first = DiscoveryPort(arguments.connection.domain, 0);
  if (taken.empty()) {
    findings.Add(Finding::kGood, "ports",
                 "UDP " + std::to_string(first) + " and the next are free");
    return;
  }
  std::string list;
  for (const std::uint16_t port : taken) list += (list.empty() ? "" : ", ") + std::to_string(port);
  findings.Add(taken.front() == first ? Finding::kWarning : Finding::kGood, "ports",
               "UDP " + list + " are in use",
               "fine if that is Tandem: others then reach this machine at the next free pair; "
               "--port fixes one");
}

void CheckSocketBuffers(Findings& findings) {
  const std::uint64_t largest = LargestSocketBuffer();
  const bool enough = largest >= kSocketBuffer;
  findings.Add(enough ? Finding::kGood : Finding::kWarning, "socket buffers",
               "up to " + std::to_string(largest) + " bytes",
               enough ? ""
                      : "a large session loses packets when this machine is busy; as root: sysctl "
                        "-w net.core.rmem_max=" +
                            std::to_string(kSocketBuffer));
}

void CheckPath(const std::string& text, const std::string& interface, Findings& findings) {
  const Result<PeerAddress> peer = ParsePeerAddress(text);
  if (!peer) {
    findings.Add(Finding::kBad, "peer " + text, peer.error().what);
    return;
  }
  const std::string what = "path to " + peer->host;
  const PathFacts path = ProbePath(peer->host, kAnswerPort, interface);
  const std::string by =
      path.address + (path.interface.empty() ? "" : " by interface " + path.interface);
  const std::string mend =
      "run tandem doctor --answer on the other machine; if it still does not answer, let UDP "
      "through its firewall, " +
      std::to_string(kAnswerPort) + " for this and the session's ports above, or use a VPN";
  if (!path.error.empty()) {
    findings.Add(Finding::kBad, what, path.error, "check the name and the network");
  } else if (path.answered == 0) {
    findings.Add(Finding::kWarning, what,
                 by + (path.refused ? " is there, but does not answer" : " is silent") +
                     "; route for packets of " + std::to_string(path.route_mtu) + " bytes",
                 mend);
  } else {
    std::array<char, 160> found{};
    std::snprintf(found.data(), found.size(),
                  "%s, round trip %.2f ms, %d of %d answered, up to %d bytes in one piece",
                  by.c_str(), path.least_round_trip_ms, path.answered, path.sent,
                  path.largest_answered);
    const bool enough = path.largest_answered >= kLeastPayload;
    findings.Add(enough ? Finding::kGood : Finding::kWarning, what, found.data(),
                 enough ? "" : "packets of a session have up to 1400 bytes: raise the path's MTU");
  }
}

void CheckDiscovery(const DoctorArguments& arguments, Findings& findings) {
  DdsOptions dds;
  dds.session = arguments.session.empty() ? "tandem-doctor" : arguments.session;
  dds.role = Role::kViewer;
  ApplyConnection(arguments.connection, dds);
  std::string name = "doctor";
  const Result<PeerId> id = Identify(arguments.connection, Role::kViewer, name);
  if (!id) {
    findings.Add(Finding::kBad, "keys", id.error().what,
                 "the doctor looks on, so give it keys of a viewer");
    return;
  }
  dds.peer = *id;
  Listener listener;
  Result<std::unique_ptr<Transport>> joined = JoinOverDds(dds, listener);
  if (!joined) {
    findings.Add(Finding::kBad, "joining", joined.error().what);
    return;
  }
  if (arguments.session.empty()) {
    findings.Add(Finding::kGood, "joining", "DDS domain " + std::to_string(dds.domain) + " opens");
    return;
  }
  MachineClock().SleepUntil(MonotonicNowNs() + kDoctorListensNs);
  const std::string names = listener.Names();
  (*joined)->Leave();
  findings.Add(names.empty() ? Finding::kWarning : Finding::kGood, "session " + arguments.session,
               names.empty() ? "no peer answered" : names,
               names.empty() ? "give the same --session, --domain and --secure on both sides; "
                               "beyond one network, give --peers"
                             : "");
}

/// Says whether the session is announced on this network, where the doctor cannot look on.
void CheckAnnounced(const DoctorArguments& arguments, Findings& findings) {
  if (arguments.session.empty()) return;
  bool received = false;
  DiscoverSessions(
      arguments.connection, kAnnouncedWithin, [&](const std::vector<AnnouncedSession>& all) {
        received = std::ranges::find(all, AnnouncedSession{arguments.session, true}) != all.end();
        return received;
      });
  findings.Add(
      Finding::kGood, "session " + CleanText(arguments.session),
      received
          ? "announced on this network"
          : "not announced on this network; only 'tandem peer' can tell more, with a peer's keys");
}

int AnswerOthers(const std::string& interface) {
  Result<ProbeResponder> responder = ProbeResponder::Open(kAnswerPort, interface);
  if (!responder) return Fail(kExitNetwork, responder.error().what);
  const std::atomic<bool>& stop_asked = StopOnSignals();
  Say("answering at UDP port " + std::to_string(kAnswerPort) +
      "; now run 'tandem doctor --peers THIS_MACHINE' on the other machine; Ctrl-C ends this");
  while (!stop_asked.load()) responder->Answer(100);
  return kExitOk;
}

/// Runs all checks. What can be said without a peer comes before the ways to peers.
int RunDoctor(DoctorArguments arguments) {
  if (arguments.answer) return AnswerOthers(arguments.connection.interface);
  if (!arguments.line.file.empty()) {
    return RunDoctorTrace(arguments.line, arguments.connection.peers, kAnswerPort, arguments.json);
  }
  if (!arguments.invitation.empty()) {
    Result<std::string> given = GivenLine(arguments.invitation);
    if (!given) return Fail(kExitUsage, "--invitation: " + given.error().what);
    arguments.invitation = *std::move(given);
  }
  Findings findings;
  Invitation invitation;
  const bool invited =
      !arguments.invitation.empty() && CheckInvitation(arguments.invitation, invitation, findings);
  if (invited) {
    arguments.session = invitation.session;
    ReachInviter(invitation, arguments.connection);
  }
  CheckScene(arguments.scene, invitation.scene, findings);
  DdsOptions dds;
  dds.session = "tandem-doctor";
  ApplyConnection(arguments.connection, dds);
  if (const std::optional<Error> wrong = CheckOptions(dds)) {
    findings.Add(Finding::kBad, "options", wrong->what);
  } else {
    CheckInterfaces(arguments, findings);
    CheckOwnAddress(arguments.connection, !arguments.connection.peers.empty(), findings);
    CheckPorts(arguments, findings);
    const auto usual = static_cast<std::uint16_t>(
        arguments.connection.port != 0 ? arguments.connection.port
                                       : DiscoveryPort(arguments.connection.domain, 0));
    CheckEnrolPort(arguments.enrol_port != 0 ? arguments.enrol_port : usual, findings);
    CheckRealtime(findings);
    CheckDisplay(findings);
    CheckSocketBuffers(findings);
    if (invited && invitation.secured && arguments.connection.secure.empty()) {
      // without keys nobody is heard: the line gives them
    } else if (CheckKeys(arguments.connection, findings)) {
      CheckDiscovery(arguments, findings);
    } else {
      CheckAnnounced(arguments, findings);
    }
    for (const std::string& peer : arguments.connection.peers) {
      CheckPath(peer, arguments.connection.interface, findings);
    }
  }
  if (arguments.json) {
    PrintText(JsonText(findings.json(), 2));
  } else {
    PrintText(findings.text());
  }
  return findings.bad() ? kExitNetwork : kExitOk;
}

}  // namespace

void AddDoctorCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<DoctorArguments>();
  CLI::App* command = app.add_subcommand(
      "doctor",
      "Check what sessions and windows need of this machine and network, and print remedies");
  AddSessionOption(*command, arguments->session, "name of a session: list its participants");
  AddConnectionOptions(*command, arguments->connection);
  command->add_option(
      "--invitation", arguments->invitation,
      "line of 'tandem invite', whole or without its secret: check that it is valid and that its "
      "inviter answers; -: read it from stdin, or ask for it; @FILE: read it from a file");
  command->add_option("--scene", arguments->scene,
                      "scene to look for on this machine, by name or file");
  command
      ->add_option("--enrol-port", arguments->enrol_port,
                   "TCP port of 'tandem invite' to check on this machine")
      ->check(WholeNumberFrom(1024, 65535));
  command->add_flag("--answer", arguments->answer, "answer another machine's doctor until Ctrl-C");
  AddLineOptions(*command, arguments->line);
  command->add_flag("--json", arguments->json, "print the findings as JSON");
  command->callback([arguments, &exit_code] {
    exit_code = RunDoctor(*arguments);
  });
}

}  // namespace tandem
