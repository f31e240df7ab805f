#pragma once

#include <CLI/CLI.hpp>

namespace tandem {

/// Adds all subcommands.
void AddCommands(CLI::App& app, int& exit_code);

/// Each function adds a subcommand whose run leaves its exit code in `exit_code`.
void AddViewCommand(CLI::App& app, int& exit_code);
void AddVoxelizeCommand(CLI::App& app, int& exit_code);
void AddCacheCommand(CLI::App& app, int& exit_code);
void AddClearanceCommand(CLI::App& app, int& exit_code);
void AddContactCommand(CLI::App& app, int& exit_code);
void AddProximityCommand(CLI::App& app, int& exit_code);
void AddDemoCommand(CLI::App& app, int& exit_code);
void AddBenchCommand(CLI::App& app, int& exit_code);
void AddDevicesCommand(CLI::App& app, int& exit_code);
void AddDoctorCommand(CLI::App& app, int& exit_code);
void AddInviteCommand(CLI::App& app, int& exit_code);
void AddKeysCommand(CLI::App& app, int& exit_code);
void AddOpenCommands(CLI::App& app, int& exit_code);
void AddPeerCommand(CLI::App& app, int& exit_code);
void AddSessionsCommand(CLI::App& app, int& exit_code);
void AddSimulateCommand(CLI::App& app, int& exit_code);
void AddRelayCommand(CLI::App& app, int& exit_code);
void AddReplayCommand(CLI::App& app, int& exit_code);
void AddStudyCommand(CLI::App& app, int& exit_code);
void AddWatchCommand(CLI::App& app, int& exit_code);

}  // namespace tandem
