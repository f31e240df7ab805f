#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/cli/commands.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/scene_files.h"
#include "app/common/stop_signal.h"
#include "app/connection/connection_options.h"
#include "app/invite/enrolment_listener.h"
#include "app/invite/invitation.h"
#include "collab/dds/diagnostics/reachability.h"
#include "collab/dds/networks/usable_networks.h"
#include "collab/dds/security/keys.h"
#include "collab/dds/transport/announcements.h"
#include "collab/dds/transport/domain.h"
#include "collab/session/early_inbox.h"
#include "collab/session/scene_agreement.h"
#include "engine/base/text/clean_text.h"
#include "engine/base/text/hex.h"
#include "engine/base/text/json_text.h"
#include "engine/realtime/clock.h"

namespace tandem {
namespace {

constexpr std::int64_t kHearSceneNs = 2'500'000'000;  // from any program in the session
constexpr std::int64_t kHearTurnNs = 20'000'000;
constexpr int kMinute = 60;
constexpr int kMostMinutes = 7 * 24 * 60;

struct InviteArguments {
  ConnectionOptions connection;
  std::string session;
  std::string scene;
  std::string keys;  // folder of the session's keys; empty: the session is plain
  std::string name;
  std::string role = "active";
  int days = 365;
  int minutes = 15;
  std::uint16_t enrol_port = 0;
  bool json = false;
};

/// Returns the addresses of this machine that others can reach, as far as it knows.
std::vector<std::string> OwnHosts(const ConnectionOptions& connection) {
  const std::string port = connection.port == 0 ? "" : ":" + std::to_string(connection.port);
  if (!connection.external_address.empty()) return {connection.external_address + port};
  std::vector<std::string> hosts;
  for (const InterfaceFacts& interface : UsableInterfaces()) {
    const bool wanted =
        connection.interface.empty() ? !interface.loopback : interface.name == connection.interface;
    if (!interface.carrier) continue;
    if (wanted && hosts.size() < Invitation::kMostHosts) hosts.push_back(interface.address + port);
  }
  return hosts;
}

/// The facts of a session that the inviter hears within a moment.
struct DiscoveredSession {
  std::optional<SceneManifest> scene;
  bool as_secured = false;
  bool has_peers = false;
};

/// Listens to a plain session, in which nobody sees the listener.
Result<DiscoveredSession> HearOf(const InviteArguments& arguments) {
  ConnectionOptions connection = arguments.connection;
  // a program on this machine with a fixed port or named peers hears no multicast: it is sought by
  // address
  if (connection.port != 0 || !connection.peers.empty()) {
    for (const InterfaceFacts& interface : UsableInterfaces()) {
      connection.peers.push_back(
          interface.address + (connection.port == 0 ? "" : ":" + std::to_string(connection.port)));
    }
  }
  connection.port = 0;
  connection.external_address.clear();
  EarlyInbox inbox;
  DdsOptions dds;
  dds.session = arguments.session;
  dds.role = Role::kViewer;
  std::string nobody = "invite";
  dds.peer = *Identify(connection, Role::kViewer, nobody);
  ApplyConnection(connection, dds);
  Result<std::unique_ptr<Transport>> joined = JoinOverDds(dds, inbox);
  if (!joined) return joined.error();
  const std::unique_ptr<SessionsNearby> nearby = ListenForSessions(dds);
  DiscoveredSession found;
  const std::int64_t until_ns = MonotonicNowNs() + kHearSceneNs;
  StopOnSignals();
  const bool wants_scene = arguments.scene.empty();
  while (!(found.has_peers && (found.scene || !wants_scene)) && MonotonicNowNs() < until_ns) {
    found.scene = inbox.SessionScene();
    found.has_peers = inbox.HasPeers() || found.scene;
    for (const AnnouncedSession& session : nearby->Heard()) {
      found.as_secured = found.as_secured || (session.secured && session.name == arguments.session);
    }
    if (found.as_secured || StopRequestedWithin(std::chrono::nanoseconds(kHearTurnNs))) break;
  }
  (*joined)->Leave();
  return found;
}

void Tell(const SceneManifest& scene, Invitation& invitation) {
  std::string file = std::filesystem::path(scene.file).filename().string();
  if (file.size() > InvitedScene::kLongestFile) file.clear();
  invitation.scene = {.digest = scene.content_digest,
                      .bodies = static_cast<std::uint32_t>(scene.bodies.size()),
                      .file = file};
}

/// Makes the line, before anybody can use it.
int PrepareLine(const InviteArguments& arguments, Invitation& invitation) {
  invitation.session = arguments.session;
  invitation.role = arguments.role == "viewer" ? Role::kViewer : Role::kActive;
  invitation.domain = arguments.connection.domain;
  invitation.hosts = OwnHosts(arguments.connection);
  invitation.others = arguments.connection.peers;
  if (invitation.hosts.empty()) {
    invitation.hosts = {"127.0.0.1"};
    Say("this machine is in no network, so the line works on this machine alone");
  }
  if (!arguments.scene.empty()) {
    const Result<Scene> scene = LoadNamedScene(arguments.scene);
    if (!scene) return Fail(kExitFile, scene.error().what);
    const Result<SceneHash> hash = HashScene(*scene);
    if (!hash) return Fail(kExitFile, hash.error().what);
    Tell(ManifestOf(*scene, *hash, 0), invitation);
  }
  return kExitOk;
}

void PrintInvitation(const InviteArguments& arguments, const Invitation& invitation) {
  const std::string line = LineOf(invitation);
  if (!arguments.json) {
    PrintLine("%s", line.c_str());
    std::fflush(stdout);
    return;
  }
  const auto or_null = [](bool there, const nlohmann::ordered_json& value) {
    return there ? value : nlohmann::ordered_json();
  };
  char end[32] = "";
  std::tm utc{};
  gmtime_r(&invitation.enrolment.until, &utc);
  std::strftime(end, sizeof end, "%Y-%m-%dT%H:%M:%SZ", &utc);
  const nlohmann::ordered_json json{
      {"line", line},
      {"session", invitation.session},
      {"secured", invitation.secured},
      {"role", arguments.role},
      {"name", or_null(!arguments.name.empty(), arguments.name)},
      {"domain", invitation.domain},
      {"hosts", invitation.hosts},
      {"others", invitation.others},
      {"scene", or_null(invitation.scene.digest.has_value(),
                        HexOfBytes(invitation.scene.digest.value_or(Sha256{})))},
      {"enrol_port", or_null(invitation.secured, invitation.enrolment.port)},
      {"until", or_null(invitation.secured, end)}};
  PrintText(JsonText(json));
  std::fflush(stdout);
}

int InvitePlainly(const InviteArguments& arguments) {
  Invitation invitation;
  if (const int failed = PrepareLine(arguments, invitation); failed != kExitOk) return failed;
  const Result<DiscoveredSession> received = HearOf(arguments);
  const bool has_scene = !arguments.scene.empty();
  if (!received && !has_scene) return Fail(kExitNetwork, received.error().what);
  if (!received) {  // the line may be for a network in which this machine is not yet
    PrintInvitation(arguments, invitation);
    Say("everybody who has this line can join with: tandem join LINE");
    return kExitOk;
  }
  const std::string session = "session " + CleanText(arguments.session);
  if (received->as_secured) {
    return Fail(kExitSecurity, session +
                                   " is secured: give the folder of its keys with --keys, and the "
                                   "invited person's name with --name");
  }
  if (!has_scene && received->scene) Tell(*received->scene, invitation);
  const bool no_scene = !invitation.scene.digest;
  if (!received->has_peers) {
    Say("nobody is in " + session + ": who joins now by this line is alone there" +
        (no_scene ? ", and the line names no scene: join first, or name the scene with --scene"
                  : ": join it yourself"));
  } else if (no_scene) {
    Say("nobody in " + session +
        " offers a scene yet, so the line names none: name the scene with --scene");
  }
  PrintInvitation(arguments, invitation);
  Say("everybody who has this line can join with: tandem join LINE");
  return kExitOk;
}

/// Returns why the folder can make no members; empty: it can.
std::string WhyNoSession(const std::string& folder) {
  std::error_code failed;
  for (const Authority& authority : {IdentityAuthority(folder), PermissionsAuthority(folder)}) {
    for (const std::filesystem::path& file : {authority.certificate, authority.key}) {
      if (!std::filesystem::exists(file, failed)) {
        return folder + ": has no " + file.filename().string() +
               ", so it cannot make members: name the folder that 'tandem keys session' made";
      }
    }
  }
  return {};
}

int InviteWithKeys(const InviteArguments& arguments) {
  if (arguments.name.empty()) {
    return Fail(kExitUsage, "--name: give the name by which others will see the invited person");
  }
  if (!IsMemberName(arguments.name)) {
    return Fail(kExitUsage, "--name: '" + CleanText(arguments.name) +
                                "' is not a member's name: use letters, digits, '.', '_' and '-'");
  }
  if (const std::string fault = WhyNoSession(arguments.keys); !fault.empty()) {
    return Fail(kExitFile, fault);
  }
  Invitation invitation;
  if (const int failed = PrepareLine(arguments, invitation); failed != kExitOk) return failed;
  const bool fixed = arguments.enrol_port != 0;
  const auto usual = static_cast<std::uint16_t>(
      arguments.connection.port != 0 ? arguments.connection.port
                                     : DiscoveryPort(arguments.connection.domain, 0));
  Result<EnrolmentListener> listener = EnrolmentListener::Open(
      fixed ? arguments.enrol_port : usual, !fixed, [&arguments](int socket, std::uint16_t port) {
        return BindToInterface(socket, arguments.connection.interface, port);
      });
  if (!listener) return Fail(kExitNetwork, listener.error().what);
  const Result<Secret128> secret = NewSecret();
  if (!secret) return Fail(kExitSecurity, secret.error().what);
  invitation.secured = true;
  const std::time_t now = std::time(nullptr);
  invitation.enrolment = {.port = listener->port(),
                          .until = now + std::time_t{arguments.minutes} * kMinute,
                          .secret = *secret,
                          .certificate = listener->certificate()};
  const std::atomic<bool>& stop = StopOnSignals();
  PrintInvitation(arguments, invitation);
  Say("give this line to " + arguments.name +
      " and to nobody else, who types 'tandem join -' and pastes it: the first person who uses it "
      "becomes a member. It works once, until " +
      TimeForAPerson(invitation.enrolment.until, now) + ", while this program runs (TCP port " +
      std::to_string(listener->port()) + "); Ctrl-C withdraws it");
  const SignFunction sign = [&arguments, &invitation](const std::string& request) {
    return SignMember(arguments.keys, arguments.name, invitation.role, request, arguments.days);
  };
  const auto tell = [](const std::string& line) {
    Say(line);
  };
  using End = EnrolmentListener::End;
  switch (listener->Serve(invitation, arguments.name, sign, tell, stop)) {
    case End::kUsed:
      Say(arguments.name + " is a member now");
      return kExitOk;
    case End::kExpired:
      return Fail(kExitNetwork, "nobody used the line in time, and it is void: make a new one");
    case End::kGuessed:
      return Fail(kExitSecurity,
                  "too many connections came without the line's secret, and the line is void: make "
                  "another, with another --enrol-port");
    case End::kStopped:
      break;
  }
  Say("the line is withdrawn");
  return kExitOk;
}

}  // namespace

void AddInviteCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<InviteArguments>();
  CLI::App* command = app.add_subcommand(
      "invite", "Print a line with which a person joins a session, in any network");
  command->add_option("SESSION", arguments->session, "name of the session")
      ->required()
      ->check(CLI::Validator(
          [](std::string& name) -> std::string {
            return WhyNoSessionName(name);
          },
          ""));
  CLI::Option* keys =
      command->add_option("--keys", arguments->keys,
                          "folder of 'tandem keys session', for a secured session: the invited "
                          "person gets a certificate over TLS, once; the command runs until then");
  command->add_option("--name", arguments->name, "name of the invited person, as others see it")
      ->needs(keys);
  command->add_option("--role", arguments->role, "active: take part; viewer: look on")
      ->check(OneOf({"active", "viewer"}))
      ->capture_default_str();
  command->add_option("--days", arguments->days, "validity of the invited person's keys, days")
      ->needs(keys)
      ->check(WholeNumberFrom(1, 36'500))
      ->capture_default_str();
  command->add_option("--minutes", arguments->minutes, "validity of the line, minutes")
      ->needs(keys)
      ->check(WholeNumberFrom(1, kMostMinutes))
      ->capture_default_str();
  command
      ->add_option("--enrol-port", arguments->enrol_port,
                   "TCP port for the invited person's certificate; default: the number of --port, "
                   "or 7410 + 250 x domain, or the next free one")
      ->needs(keys)
      ->check(WholeNumberFrom(1024, 65535));
  command->add_option("--scene", arguments->scene,
                      "scene of the session, by name or file; default: the scene that the peers of "
                      "a plain session offer");
  AddConnectionOptions(*command, arguments->connection);
  command->remove_option(command->get_option("--secure"));
  command->add_flag("--json", arguments->json, "print one JSON object, which contains the line");
  command->callback([arguments, &exit_code] {
    exit_code = arguments->keys.empty() ? InvitePlainly(*arguments) : InviteWithKeys(*arguments);
  });
}

}  // namespace tandem
