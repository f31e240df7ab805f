#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "collab/peer.h"
#include "engine/base/result.h"
#include "engine/realtime/frame_stats.h"

namespace tandem {

/// What a peer says of itself at the end of a run.
struct PeerReport {
  std::string name;
  int pid = 0;
  std::string scheduler;
  std::size_t points = 0;   // of the body in hand
  std::size_t voxels = 0;   // of the fixture
  double capacity = 0;      // point tests that fit into a frame
  double mean_delay_s = 0;  // half the loop age
};

/// One JSON object: frames, missed, frame_cpu_us and lateness_us {p50, p99, max}, and of the trace
/// contact_points {mean, max}, contact_share, peak_force_N.
nlohmann::ordered_json AsJson(const PeerReport& report, const FrameStats& stats,
                              const std::vector<TraceSample>& trace);

/// The trace as a file of doubles, 17 a frame: see kTraceColumns.
inline constexpr std::size_t kTraceColumns = 17;
Result<bool> WriteTrace(const std::filesystem::path& file, const std::vector<TraceSample>& trace);
Result<std::vector<TraceSample>> ReadTrace(const std::filesystem::path& file);

}  // namespace tandem
