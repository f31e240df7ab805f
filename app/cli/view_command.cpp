#include <cerrno>
#include <cstring>
#include <string_view>

#include <unistd.h>

#include "app/cli/commands.h"
#include "app/common/exit_codes.h"
#include "app/common/scene_files.h"
#include "app/common/talk.h"
#include "app/process/child_processes.h"

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
  const std::string program = (ProgramFolder() / "tandem-view").string();
  std::vector<char*> argv{const_cast<char*>(program.c_str())};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  execv(program.c_str(), argv.data());
  return Fail(kExitFailed, program + " cannot be started: " + std::strerror(errno));
}

}  // namespace

void AddViewCommand(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand(
      "view", "Look on in a window: tandem-view, with all its options (tandem view --help)");
  command->prefix_command();
  command->set_help_flag();
  command->callback([command, &exit_code] {
    exit_code = RunView(command->remaining());
  });
}

}  // namespace tandem
