#include <cstdio>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "app/cli/commands.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/stop_signal.h"
#include "app/join/discover_sessions.h"
#include "collab/dds/transport/announcements.h"
#include "collab/dds/transport/domain.h"
#include "engine/base/text/clean_text.h"
#include "engine/base/text/json_text.h"

namespace tandem {
namespace {

constexpr double kListensFor = 2;  // s; each program announces itself more often

struct SessionsArguments {
  ConnectionOptions connection;
  double seconds = kListensFor;
  bool json = false;
};

int ListSessions(const SessionsArguments& arguments) {
  DdsOptions dds;
  dds.session = "tandem-sessions";
  ApplyConnection(arguments.connection, dds);
  if (const std::optional<Error> wrong = CheckOptions(dds)) return Fail(kExitUsage, wrong->what);
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  std::string lines;
  for (const AnnouncedSession& session :
       DiscoverSessions(arguments.connection, arguments.seconds, [](const auto&) {
         return false;
       })) {
    const bool relay = session.name.ends_with(kBehindRelay);
    const std::string name =
        relay ? session.name.substr(0, session.name.size() - kBehindRelay.size()) : session.name;
    rows.push_back({{"session", name}, {"secured", session.secured}, {"relay", relay}});
    lines += CleanText(name) + (session.secured ? "  secured" : "  plain") +
             (relay ? ", through a relay" : "") + "\n";
  }
  if (arguments.json) {
    const nlohmann::ordered_json found{{"domain", arguments.connection.domain}, {"sessions", rows}};
    PrintText(JsonText(found));
    return kExitOk;
  }
  if (!lines.empty()) PrintText(lines);
  if (lines.empty()) {
    Say("no session is announced on this network in domain " +
        std::to_string(arguments.connection.domain) +
        "; to join one in another network, ask there for an invitation ('tandem invite')");
  }
  return kExitOk;
}

}  // namespace

void AddSessionsCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<SessionsArguments>();
  CLI::App* command = app.add_subcommand("sessions", "List the open sessions on this network");
  AddConnectionOptions(*command, arguments->connection);
  // options on one's own place do not matter to a listener
  for (const char* option : {"--external-address", "--port", "--secure"}) {
    command->remove_option(command->get_option(option));
  }
  command->add_option("--seconds", arguments->seconds, "duration of listening, s")
      ->check(NumberAbove(0, kLongestRun))
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments, &exit_code] {
    exit_code = ListSessions(*arguments);
  });
}

}  // namespace tandem
