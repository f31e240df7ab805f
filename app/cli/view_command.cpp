#include <string_view>

#include "app/cli/commands.h"
#include "app/common/scene_files.h"
#include "app/process/become_program.h"

namespace tandem {

namespace {

/// Becomes the window's program, which lies beside this one.
int RunView(std::vector<std::string> arguments) {
  // the window's program knows scenes by their files alone
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    constexpr std::string_view kScene = "--scene=";
    if (arguments[i] == "--scene" && i + 1 < arguments.size()) {
      ++i;
      arguments[i] = SceneFile(arguments[i]).string();
    } else if (arguments[i].rfind(kScene, 0) == 0) {
      arguments[i] = std::string(kScene) + SceneFile(arguments[i].substr(kScene.size())).string();
    }
  }
  return BecomeProgram("tandem-view", arguments);
}

}  // namespace

void AddViewCommand(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand(
      "view",
      "Watch a session in a window: runs tandem-view with all its options (tandem view --help)");
  command->prefix_command();
  command->set_help_flag();
  command->callback([command, &exit_code] {
    exit_code = RunView(command->remaining());
  });
}

}  // namespace tandem
