#pragma once

#include <filesystem>
#include <vector>

#include "collab/messages.h"
#include "collab/peer.h"
#include "engine/base/result.h"

namespace tandem {

/// Returns the poses of another peer's instance of the body as a recording heard them, at the times
/// at which they were: by our clock. The difference of both clocks is estimated from echoes
/// (EstimateClocks()), so times are off by half of what the ways there and back differ in delay.
/// Only poses and times are set. Empty: no peer's instance was heard for long enough. Of several
/// other peers the one that was heard most counts. Errors: the recording cannot be read.
Result<std::vector<TraceSample>> TraceHeard(const std::filesystem::path& recording,
                                            ObjectId object);

}  // namespace tandem
