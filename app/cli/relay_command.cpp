#include <csignal>
#include <cstdio>
#include <ctime>
#include <memory>

#include <unistd.h>

#include "app/cli/commands.h"
#include "app/cli/reach_options.h"
#include "app/cli/talk.h"
#include "app/exit_codes.h"
#include "collab/dds/dds_transport.h"
#include "collab/dds/relay.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

constexpr std::int64_t kTurnNs = 250'000'000;      // says that it is here
constexpr std::int64_t kStatusNs = 5'000'000'000;  // says what it does

struct RelayArguments {
  RelayOptions relay;
  ReachOptions reach;
  std::string name;
  double seconds = 0;
};

int RunRelay(RelayArguments arguments) {
  // before any thread starts, so that none of them takes the signals
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);

  if (!arguments.reach.secure.empty()) {
    return Fail(kExitUsage, "a relay's viewers need no keys: it does not show a secured session");
  }
  const Result<PeerId> id = Identify(arguments.reach, Role::kViewer, arguments.name);
  if (!id) return Fail(kExitSecurity, id.error().what);
  arguments.relay.domain = arguments.reach.domain;
  arguments.relay.interface = arguments.reach.interface;
  const Result<std::unique_ptr<Relay>> relay = Relay::Open(arguments.relay);
  if (!relay) return Fail(kExitNetwork, relay.error().what);
  DdsOptions upstream;
  upstream.session = arguments.relay.session;
  upstream.peer = *id;
  upstream.role = Role::kViewer;
  ApplyReach(arguments.reach, upstream);
  const Result<std::unique_ptr<Transport>> joined = JoinOverDds(upstream, **relay);
  if (!joined) return Fail(kExitNetwork, joined.error().what);
  Say("relaying session " + arguments.relay.session +
      "; viewers see it with: tandem watch --from-relay --session " + arguments.relay.session);

  PeerInfo info;
  info.peer = upstream.peer;
  info.role = Role::kViewer;
  info.name = arguments.name;
  const std::int64_t opened_ns = MonotonicNowNs();
  std::int64_t now_ns = opened_ns;
  std::int64_t status_ns = opened_ns;
  std::uint64_t told = 0;
  do {
    (*joined)->Publish(info);
    ++info.beat;
    if (now_ns - status_ns >= kStatusNs) {
      const std::uint64_t passed = (*relay)->views_passed_on();
      const auto each_s =
          static_cast<double>(passed - told) / (1e-9 * static_cast<double>(kStatusNs));
      Say(std::to_string(static_cast<long>(each_s)) + " pictures/s to " +
          std::to_string((*relay)->viewers()) + " viewers");
      told = passed;
      status_ns = now_ns;
    }
    const timespec turn{0, kTurnNs};
    if (sigtimedwait(&signals, nullptr, &turn) > 0) break;
    now_ns = MonotonicNowNs();
  } while (arguments.seconds <= 0 ||
           static_cast<double>(now_ns - opened_ns) < 1e9 * arguments.seconds);
  (*joined)->Leave();
  (*relay)->Leave();
  return kExitOk;
}

}  // namespace

void AddRelayCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<RelayArguments>();
  arguments->name = "relay-" + std::to_string(getpid());
  CLI::App* command = app.add_subcommand(
      "relay", "Show a session to many: its peers serve the relay alone, the relay the viewers");
  command->add_option("--session", arguments->relay.session, "name of the session")->required();
  command->add_option("--name", arguments->name, "how the session's peers see it");
  AddReachOptions(*command, arguments->reach);
  command->add_option("--seconds", arguments->seconds, "leave after this; 0: on a signal")
      ->check(CLI::NonNegativeNumber);
  command->callback([arguments, &exit_code] {
    exit_code = RunRelay(*arguments);
  });
}

}  // namespace tandem
