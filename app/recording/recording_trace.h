#pragma once

#include <filesystem>
#include <vector>

#include "collab/peer/peer.h"
#include "collab/session/messages.h"
#include "engine/base/result.h"

namespace tandem {

/// Returns the poses of another peer's instance of the body as a recording heard them, with their
/// times by our clock. The difference of both clocks is estimated from echoes (EstimateClocks()).
/// So times are off by half of what the ways there and back differ in delay. Only poses and times
/// are set. Of several other peers, the peer that was heard most counts. Empty: no peer's instance
/// was heard for long enough. Errors: the recording cannot be read.
Result<std::vector<TraceSample>> TraceOfRecording(const std::filesystem::path& recording,
                                                  ObjectId object);

}  // namespace tandem
