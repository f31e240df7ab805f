#include <cstdio>
#include <exception>

#include <CLI/CLI.hpp>

#include "app/cli/commands.h"
#include "app/cli/watch_command.h"
#include "app/exit_codes.h"
#include "engine/geometry/mesh_file.h"

int main(int argc, char** argv) {
  tandem::RunImportHelperIfAsked(argc, argv);
  CLI::App app{"Tandem: several people at several sites, one digital mock-up in all their hands"};
  app.name("tandem");
  app.require_subcommand(1);
  app.set_version_flag("--version", TANDEM_VERSION);
  int exit_code = tandem::kExitOk;
  tandem::AddDemoCommand(app, exit_code);
  tandem::AddPeerCommand(app, exit_code);
  tandem::AddViewCommand(app, exit_code);
  tandem::AddWatchCommand(app, exit_code);
  tandem::AddRelayCommand(app, exit_code);
  tandem::AddVoxelizeCommand(app, exit_code);
  tandem::AddContactCommand(app, exit_code);
  tandem::AddBenchCommand(app, exit_code);
  tandem::AddProximityCommand(app, exit_code);
  tandem::AddKeysCommand(app, exit_code);
  tandem::AddSimulateCommand(app, exit_code);
  tandem::AddDoctorCommand(app, exit_code);
  tandem::AddReplayCommand(app, exit_code);
  tandem::AddStabilityCommand(app, exit_code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? tandem::kExitOk : tandem::kExitUsage;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tandem: %s\n", error.what());
    return tandem::kExitFailed;
  }
  return exit_code;
}
