#include <CLI/CLI.hpp>

#include "app/cli/commands.h"
#include "app/exit_codes.h"
#include "app/option_checks.h"
#include "app/stop_signal.h"
#include "engine/geometry/mesh_file.h"

int main(int argc, char** argv) {
  tandem::RunImportHelperIfAsked(argc, argv);
  tandem::HandleSignals();
  CLI::App app{"Tandem: several people at several sites, one digital mock-up in all their hands"};
  app.name("tandem");
  app.require_subcommand(1);
  app.set_version_flag("--version", TANDEM_VERSION);
  int exit_code = tandem::kExitOk;
  tandem::AddCommands(app, exit_code);
  if (const std::optional<int> ended = tandem::ParseOrExplain(app, argc, argv)) return *ended;
  return exit_code;
}
