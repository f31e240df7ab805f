#include "app/cli/commands.h"
#include "app/process/become_program.h"

namespace tandem {

/// Its subcommands are those of tandem-bench (app/bench), a program of its own.
void AddBenchCommand(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand(
      "bench", "Measure the engine and compare it with the limits of this machine");
  command->prefix_command();
  command->set_help_flag();
  command->callback([command, &exit_code] {
    exit_code = BecomeProgram("tandem-bench", command->remaining());
  });
}

}  // namespace tandem
