#include "app/bench/bench_commands.h"

namespace tandem {

void AddBenches(CLI::App& bench, int& exit_code) {
  bench.require_subcommand(1);
  AddBenchMemory(bench, exit_code);
  AddBenchDevice(bench, exit_code);
  AddBenchFrame(bench, exit_code);
  AddBenchHostile(bench, exit_code);
  AddBenchPoints(bench, exit_code);
  AddBenchProximity(bench, exit_code);
  AddBenchRemoval(bench, exit_code);
  AddBenchVoxelize(bench, exit_code);
  AddBenchFidelity(bench, exit_code);
  AddBenchTable1(bench, exit_code);
  AddBenchFigure10(bench, exit_code);
  AddBenchNetwork(bench, exit_code);
  AddBenchOpening(bench, exit_code);
  AddBenchWindow(bench, exit_code);
  AddBenchSession(bench, exit_code);
}

void AddWholeBench(CLI::App& app, int& exit_code) {
  CLI::App* bench = app.add_subcommand(
      "bench", "Measure the engine and compare it with the limits of this machine");
  AddBenches(*bench, exit_code);
}

}  // namespace tandem
