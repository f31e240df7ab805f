#pragma once

#include <CLI/CLI.hpp>

namespace tandem {

/// Adds the subcommand `bench` with all of its own.
void AddWholeBench(CLI::App& app, int& exit_code);

/// Adds the subcommands of `bench` alone.
void AddBenches(CLI::App& bench, int& exit_code);

/// Each function adds a subcommand of `tandem bench`, whose run leaves its exit code in
/// `exit_code`.
void AddBenchMemory(CLI::App& bench, int& exit_code);
void AddBenchDevice(CLI::App& bench, int& exit_code);
void AddBenchFrame(CLI::App& bench, int& exit_code);
void AddBenchHostile(CLI::App& bench, int& exit_code);
void AddBenchPoints(CLI::App& bench, int& exit_code);
void AddBenchProximity(CLI::App& bench, int& exit_code);
void AddBenchRemoval(CLI::App& bench, int& exit_code);
void AddBenchVoxelize(CLI::App& bench, int& exit_code);
void AddBenchFidelity(CLI::App& bench, int& exit_code);
void AddBenchTable1(CLI::App& bench, int& exit_code);
void AddBenchFigure10(CLI::App& bench, int& exit_code);
void AddBenchNetwork(CLI::App& bench, int& exit_code);
void AddBenchOpening(CLI::App& bench, int& exit_code);
void AddBenchWindow(CLI::App& bench, int& exit_code);
void AddBenchSession(CLI::App& bench, int& exit_code);

}  // namespace tandem
