#include "app/cli/commands.h"

#include "app/stability/cli/stability_command.h"

namespace tandem {

void AddCommands(CLI::App& app, int& exit_code) {
  AddDemoCommand(app, exit_code);
  AddOpenCommands(app, exit_code);
  AddInviteCommand(app, exit_code);
  AddSessionsCommand(app, exit_code);
  AddPeerCommand(app, exit_code);
  AddViewCommand(app, exit_code);
  AddWatchCommand(app, exit_code);
  AddRelayCommand(app, exit_code);
  AddVoxelizeCommand(app, exit_code);
  AddCacheCommand(app, exit_code);
  AddContactCommand(app, exit_code);
  AddBenchCommand(app, exit_code);
  AddProximityCommand(app, exit_code);
  AddKeysCommand(app, exit_code);
  AddSimulateCommand(app, exit_code);
  AddDevicesCommand(app, exit_code);
  AddDoctorCommand(app, exit_code);
  AddReplayCommand(app, exit_code);
  AddClearanceCommand(app, exit_code);
  AddStabilityCommand(app, exit_code);
  AddStudyCommand(app, exit_code);
}

}  // namespace tandem
