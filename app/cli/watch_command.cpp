#include <memory>

#include <unistd.h>

#include "app/cli/commands.h"
#include "app/common/option_checks.h"
#include "app/peer/run_watch.h"

namespace tandem {

void AddWatchCommand(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<WatchOptions>();
  options->name = "watch-" + std::to_string(getpid());
  CLI::App* command = app.add_subcommand("watch", "Look on at a session without a window");
  AddSessionOption(*command, options->session, "name of the session")->required();
  CLI::Option* scene = command->add_option(
      "--scene", options->scene, "compare this scene with the session's: its name or file");
  AddSceneFetchOptions(*command, scene, options->scene_from_session, options->fetch.accept,
                       options->fetch.limit_mb);
  command->add_option("--name", options->name, "how others see you");
  AddReachOptions(*command, options->reach);
  command->add_option("--seconds", options->seconds, "leave after this; 0: on a signal")
      ->check(NumberFrom(0, kLongestRun));
  command->add_option("--report", options->report, "write what was received (JSON) there");
  command->add_flag("--as-part", options->as_part)->group("");
  command->add_flag("--from-relay", options->from_relay, "look through a relay (tandem relay)");
  command->add_flag("--json", options->json, "print the report on stdout");
  command->callback([options, &exit_code] {
    exit_code = WatchCommand(*options);
  });
}

}  // namespace tandem
