#include "app/stability/cli/stability_command.h"

namespace tandem {

void AddStabilityCommand(CLI::App& app, int& exit_code) {
  CLI::App* stability = app.add_subcommand(
      "stability", "Run delay experiments: whole peers in virtual time, judged by numbers");
  stability->require_subcommand(1);
  AddStabilityLive(*stability, exit_code);
  AddStabilityPress(*stability, exit_code);
  AddStabilityRandom(*stability, exit_code);
  AddStabilityRun(*stability, exit_code);
  AddStabilitySweep(*stability, exit_code);
  AddStabilityTrace(*stability, exit_code);
  AddStabilityMerge(*stability, exit_code);
  AddStabilityBoundary(*stability, exit_code);
  AddStabilityReport(*stability, exit_code);
}

}  // namespace tandem
