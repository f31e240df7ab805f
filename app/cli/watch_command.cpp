#include <memory>

#include <unistd.h>

#include "app/cli/commands.h"
#include "app/common/option_checks.h"
#include "app/peer/run_watch.h"

namespace tandem {

void AddWatchCommand(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<WatchOptions>();
  options->name = "watch-" + std::to_string(getpid());
  CLI::App* command = app.add_subcommand("watch", "Watch a session without a window");
  AddSessionOption(*command, options->session, "name of the session")->required();
  CLI::Option* scene = command->add_option("--scene", options->scene,
                                           "scene to compare with the session's, by name or file");
  AddSceneFetchOptions(*command, scene, options->scene_from_session, options->fetch.accept,
                       options->fetch.limit_mb);
  command->add_option("--name", options->name, "name that others see");
  AddConnectionOptions(*command, options->connection);
  command
      ->add_option("--seconds", options->seconds,
                   "time until the program leaves, s; 0: run until a signal")
      ->check(NumberFrom(0, kLongestRun));
  command->add_option("--report", options->report, "report file (JSON) for what was received");
  command->add_flag("--as-part", options->as_part)->group("");
  command->add_flag("--from-relay", options->from_relay,
                    "connect to a relay of the session ('tandem relay')");
  command->add_flag("--json", options->json, "print the report on stdout as JSON");
  command->callback([options, &exit_code] {
    exit_code = WatchCommand(*options);
  });
}

}  // namespace tandem
