#pragma once

#include <filesystem>
#include <vector>

#include "collab/lab/case_run.h"

namespace tandem {

/// What live peers' recordings show of a case that they ran: each peer is run again from what it
/// heard and felt, bit for bit, and all are measured together as a run in virtual time is. One
/// thread.
struct RecordedRun {
  Metrics metrics;
  Verdict verdict = Verdict::kUndecided;
  double seconds = 0;  // measured, from when all loops were closed and all hands had begun
};

/// `recordings`: one of each user, in the order of the case, all of one machine, whose clock they
/// share: frames that are equal in time to half a millisecond are measured together, a frame that a
/// peer missed shows what it showed before. `test`: fitted to the scene's body. Errors: a file that
/// cannot be read or repeated, loops that never closed, recordings shorter than the case.
Result<RecordedRun> MeterRecordings(const std::vector<std::filesystem::path>& recordings,
                                    const LabCase& test, const LabScene& scene,
                                    const SeriesSink& series = {});

}  // namespace tandem
