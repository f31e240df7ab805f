#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>

#include <unistd.h>

#include "app/cli/commands.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/stop_signal.h"
#include "app/connection/connection_options.h"
#include "collab/dds/security/keys.h"
#include "collab/dds/transport/dds_transport.h"
#include "collab/dds/transport/relay.h"
#include "engine/base/units.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

constexpr std::int64_t kTurnNs = 250'000'000;      // period of "I am here"
constexpr std::int64_t kStatusNs = 5'000'000'000;  // period of a line on the work

struct RelayArguments {
  std::string session;
  ConnectionOptions connection;
  ConnectionOptions audience;  // interface, port and keys of the viewers' side
  std::string name;
  double seconds = 0;
};

/// Returns how the viewers' side is reached. It is on the session's domain and, by default, on its
/// interface.
ConnectionOptions AudienceOf(const RelayArguments& arguments) {
  ConnectionOptions audience = arguments.audience;
  audience.domain = arguments.connection.domain;
  audience.external_address = arguments.connection.external_address;
  if (audience.interface.empty()) audience.interface = arguments.connection.interface;
  return audience;
}

/// Opens the viewers' side. Returns the exit code.
int OpenRelay(const RelayArguments& arguments, std::unique_ptr<Relay>& relay) {
  const ConnectionOptions audience = AudienceOf(arguments);
  DdsOptions viewers;
  viewers.session = arguments.session;
  ApplyConnection(audience, viewers);
  GoToRelay(viewers);
  Result<std::unique_ptr<Relay>> opened = Relay::Open(viewers);
  if (!opened) {
    return Fail(audience.secure.empty() ? kExitNetwork : kExitSecurity, opened.error().what);
  }
  relay = *std::move(opened);
  if (!arguments.connection.secure.empty()) {
    const Result<bool> two =
        AreOfTwoSessions(arguments.connection.secure, arguments.audience.secure);
    if (!two) return Fail(kExitSecurity, two.error().what);
  }
  return kExitOk;
}

/// Relays until a signal, the end of the keys or of the time. Returns the exit code.
int RelayUntilEnd(const RelayArguments& arguments, PeerId id, Relay& relay, Transport& joined) {
  PeerInfo info;
  info.peer = id;
  info.role = Role::kViewer;
  info.name = arguments.name;
  const std::int64_t opened_ns = MonotonicNowNs();
  std::int64_t now_ns = opened_ns;
  std::int64_t turn_ns = opened_ns;  // due time, so that a turn's length does not add up
  std::int64_t status_ns = opened_ns;
  std::uint64_t reported = 0;
  do {
    joined.Publish(info);
    ++info.beat;
    if (now_ns - status_ns >= kStatusNs) {
      const std::uint64_t passed = relay.views_passed_on();
      const auto each_s = static_cast<double>(passed - reported) / ToSeconds(kStatusNs);
      Say(std::to_string(static_cast<long>(each_s)) + " pictures/s to " +
          WithPlural(relay.viewers(), "viewer"));
      reported = passed;
      status_ns = now_ns;
    }
    turn_ns = std::max(turn_ns + kTurnNs, MonotonicNowNs());
    const std::int64_t left_ns = std::clamp<std::int64_t>(turn_ns - MonotonicNowNs(), 0, kTurnNs);
    std::string ended = joined.KeysEnd();
    if (ended.empty()) ended = relay.KeysEnd();
    if (!ended.empty()) return Fail(kExitSecurity, ended);
    if (StopRequestedWithin(std::chrono::nanoseconds(left_ns))) break;
    now_ns = MonotonicNowNs();
  } while (arguments.seconds <= 0 ||
           static_cast<double>(now_ns - opened_ns) < 1e9 * arguments.seconds);
  return kExitOk;
}

int RunRelay(RelayArguments arguments) {
  StopOnSignals();
  if (!arguments.connection.secure.empty() && arguments.audience.secure.empty()) {
    return Fail(kExitUsage,
                "only holders of keys may see a secured session: give --audience-secure with keys "
                "made by 'tandem keys relay'");
  }
  const Result<PeerId> id = Identify(arguments.connection, Role::kViewer, arguments.name);
  if (!id) return Fail(kExitSecurity, id.error().what);
  std::unique_ptr<Relay> relay;
  if (const int failed = OpenRelay(arguments, relay); failed != kExitOk) return failed;
  DdsOptions upstream;
  upstream.session = arguments.session;
  upstream.peer = *id;
  upstream.role = Role::kViewer;
  ApplyConnection(arguments.connection, upstream);
  const Result<std::unique_ptr<Transport>> joined = JoinOverDds(upstream, *relay);
  if (!joined) {
    return Fail(arguments.connection.secure.empty() ? kExitNetwork : kExitSecurity,
                joined.error().what);
  }
  const AtForcedEnd goodbye([&joined, &relay] {
    (*joined)->SayGoodbye();
    relay->SayGoodbyes();
  });
  Say("relaying session " + arguments.session + "; viewers see it with: tandem watch --from-relay" +
      (arguments.audience.secure.empty() ? "" : " --secure KEYS") + " --session " +
      arguments.session);
  Say(SecurityOf(arguments.connection, arguments.session));
  const int exit_code = RelayUntilEnd(arguments, upstream.peer, *relay, **joined);
  (*joined)->Leave();
  SayStillEnding();
  relay->Leave();
  return exit_code;
}

}  // namespace

void AddRelayCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<RelayArguments>();
  arguments->name = "relay-" + std::to_string(getpid());
  CLI::App* command = app.add_subcommand("relay",
                                         "Relay a session to many viewers: its peers send to the "
                                         "relay alone, and the relay to the viewers");
  AddSessionOption(*command, arguments->session, "name of the session to relay")->required();
  command->add_option("--name", arguments->name, "name that the session's peers see");
  AddConnectionOptions(*command, arguments->connection);
  command->add_option("--audience-interface", arguments->audience.interface,
                      "network interface of the viewers; default: the session's");
  command
      ->add_option("--audience-port", arguments->audience.port,
                   "UDP port for viewers beyond the local network; the relay uses the next one too")
      ->check(WholeNumberFrom(1024, 65534));
  command->add_option("--audience-secure", arguments->audience.secure,
                      "folder made by 'tandem keys relay' in a session for viewers ('tandem keys "
                      "session --audience'): only viewers with its keys are admitted");
  command
      ->add_option("--seconds", arguments->seconds,
                   "time until the relay leaves, s; 0: run until a signal")
      ->check(NumberFrom(0, kLongestRun));
  command->callback([arguments, &exit_code] {
    exit_code = RunRelay(*arguments);
  });
}

}  // namespace tandem
