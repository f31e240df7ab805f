#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "collab/lab/recorded_run.h"

namespace tandem {

/// A case of the lab as real peers did it.
struct LiveRun {
  RecordedRun run;
  std::uint64_t frames = 0;  // of all peers
  std::uint64_t missed = 0;
  std::string scheduler;

  double missed_share() const {
    return static_cast<double>(missed) /
           static_cast<double>(std::max<std::uint64_t>(frames + missed, 1));
  }
  /// So many frames came too late that the run shows the machine, not the case.
  bool too_busy() const { return missed_share() > 0.01; }
};

/// Starts a `tandem peer` for each user, over DDS on this machine, and measures their recordings.
/// Hand files, network plans, recordings and reports are left in `folder`. Delays are those of each
/// peer's link conditioner, or, with `tap`, of a network of real packets (TapHub), which needs
/// root. `test`: fitted to the scene's body. Errors: a peer that failed, or what MeterRecordings()
/// finds.
Result<LiveRun> RunLive(const LabCase& test, const LabScene& scene,
                        const std::filesystem::path& folder, bool tap);

/// A case that was run once, or twice where the machine was too busy.
struct LiveTries {
  LiveRun last;
  int count = 0;
  std::filesystem::path folder;  // of the last try
};

using LiveTry = std::function<Result<LiveRun>(const std::filesystem::path& folder)>;

/// Each try has an empty folder of its own: try-1 and try-2 of `keep`, or a temporary one where
/// `keep` is empty. Errors: those of a try.
Result<LiveTries> TryLive(const std::filesystem::path& keep, const LiveTry& run);

}  // namespace tandem
