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

/// Names the scene that a bench loads, and the changes to it.
struct BenchScene {
  std::string scene;       // name of a scene of ours, or a file
  double voxel_size = 0;   // m; 0: the scene's own
  std::size_t points = 0;  // number for the first moving body, about; 0: as the scene gives them
  /// If the scene fixes no body, all but the first hand's body are held fast.
  bool needs_fixture = false;
  /// The world has pointshells and voxmaps, whatever the scene's contact model.
  bool needs_plain_parts = false;
};

/// Adds the options --scene and --voxel.
void AddBenchScene(CLI::App& command, BenchScene& scene);
/// Loads the scene. An error says what to do about it.
Result<std::shared_ptr<const WorldModel>> LoadBenchScene(const BenchScene& scene);

/// Returns the processor time that `work` takes on the calling thread, ns.
template <class Work>
double CpuNs(const Work& work) {
  LoopClock& clock = MachineClock();
  const std::int64_t begin = clock.ThreadCpuNs();
  work();
  return static_cast<double>(clock.ThreadCpuNs() - begin);
}
/// Returns the wall-clock time that `work` takes, ns. It suits work on several threads.
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
