#pragma once

#include <CLI/CLI.hpp>

namespace tandem {

/// Each function adds a subcommand of `tandem stability`, whose run leaves its exit code in
/// `exit_code`.
void AddStabilityLive(CLI::App& stability, int& exit_code);
void AddStabilityPress(CLI::App& stability, int& exit_code);
void AddStabilityRandom(CLI::App& stability, int& exit_code);
void AddStabilityRun(CLI::App& stability, int& exit_code);
void AddStabilitySweep(CLI::App& stability, int& exit_code);
void AddStabilityTrace(CLI::App& stability, int& exit_code);
void AddStabilityMerge(CLI::App& stability, int& exit_code);
void AddStabilityBoundary(CLI::App& stability, int& exit_code);
void AddStabilityReport(CLI::App& stability, int& exit_code);

/// Adds the subcommand `stability` with all of these.
void AddStabilityCommand(CLI::App& app, int& exit_code);

}  // namespace tandem
