#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "collab/lab/run/recorded_run.h"

namespace tandem {

/// A case of the lab, run by real peers.
struct LiveRun {
  RecordedRun run;
  std::uint64_t frames = 0;  // frames of all peers
  std::uint64_t missed = 0;
  std::string scheduler;

  double missed_share() const {
    return static_cast<double>(missed) /
           static_cast<double>(std::max<std::uint64_t>(frames + missed, 1));
  }
  /// Returns whether so many frames came too late that the run shows the machine, not the case.
  bool too_busy() const { return missed_share() > 0.01; }
};

/// Starts a `tandem peer` for each user, over DDS on this machine, and measures their recordings.
/// Hand files, network plans, recordings and reports stay in `folder`. Each peer's link conditioner
/// makes the delays. With `tap` a network of real packets makes them (TapHub), which needs root.
/// `test`: a case fitted to the scene's body. Errors: a peer that failed, a file or network that
/// cannot be made, or those of MeterRecordings().
Result<LiveRun> RunLive(const LabCase& test, const LabScene& scene,
                        const std::filesystem::path& folder, bool tap);

/// The tries of a case: one, or two if the machine was too busy.
struct LiveTries {
  LiveRun last;
  int count = 0;
  std::filesystem::path folder;  // folder of the last try
};

using LiveTry = std::function<Result<LiveRun>(const std::filesystem::path& folder)>;

/// Runs a case once, or twice if the machine was too busy. Each try has a folder of its own: try-1
/// and try-2 of `keep`, or a temporary one if `keep` is empty. Errors: those of a try.
Result<LiveTries> TryLive(const std::filesystem::path& keep, const LiveTry& run);

}  // namespace tandem
