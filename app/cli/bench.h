#pragma once

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "engine/base/result.h"
#include "engine/realtime/clock.h"
#include "engine/world/world_model.h"

namespace tandem {

/// Each adds a subcommand of `tandem bench`, whose run leaves its exit code in `exit_code`.
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

/// Where a bench takes its bodies from.
struct BenchScene {
  std::string scene;       // a scene of ours by name, or a file
  double voxel_size = 0;   // m; 0: the scene's own
  std::size_t points = 0;  // of the first moving body, about; 0: a point for each of its voxels
  /// Where the scene fixes nothing, all but the first hand's body is held fast.
  bool needs_fixture = false;
  /// Pointshells and voxmaps, whatever the contact model of the scene.
  bool needs_plain_parts = false;
};

/// The options --scene and --voxel.
void AddBenchScene(CLI::App& command, BenchScene& scene);
/// Loads it; an error says what to do about it.
Result<std::shared_ptr<const WorldModel>> LoadBenchScene(const BenchScene& scene);

/// What `work` takes of the calling thread's processor time, ns.
template <class Work>
double CpuNs(const Work& work) {
  LoopClock& clock = MachineClock();
  const std::int64_t begin = clock.ThreadCpuNs();
  work();
  return static_cast<double>(clock.ThreadCpuNs() - begin);
}
/// The same by the wall's clock, for several threads.
template <class Work>
double WallNs(const Work& work) {
  const std::int64_t begin = MonotonicNowNs();
  work();
  return static_cast<double>(MonotonicNowNs() - begin);
}

inline double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace tandem
