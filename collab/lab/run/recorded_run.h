#pragma once

#include <filesystem>
#include <vector>

#include "collab/lab/run/case_run.h"

namespace tandem {

/// The figures of a case that live peers ran and recorded. Each peer is run again from its recorded
/// inputs, bit for bit. All peers are measured together, as in a run in virtual time. One thread.
struct RecordedRun {
  Metrics metrics;
  Verdict verdict = Verdict::kUndecided;
  double seconds = 0;  // measured time, from when all loops were closed and all hands had begun
};

/// Measures `recordings`, one of each user in the order of the case, all made on one machine by one
/// clock. Frames of all users that are equal in time to half a millisecond are measured together. A
/// frame that a peer missed shows the frame before it. `test` is fitted to the scene's body.
/// Errors: a file that cannot be read or repeated, or recordings that end before the case does, as
/// they do when loops never closed.
Result<RecordedRun> MeterRecordings(const std::vector<std::filesystem::path>& recordings,
                                    const LabCase& test, const LabScene& scene,
                                    const SeriesSink& series = {});

}  // namespace tandem
