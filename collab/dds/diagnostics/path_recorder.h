#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "collab/dds/diagnostics/path_messages.h"
#include "collab/trace/path_record.h"
#include "engine/base/result.h"

namespace tandem {

/// A line as both of its ends recorded it for a while.
struct RecordedPath {
  std::string address;
  PathRecord record;
  /// For each sample that came back, ns: its arrival minus the newest own sending that the other
  /// end had, and how long the other end had held that. The difference is a round trip.
  std::vector<std::int64_t> loop_age_ns;
  std::vector<std::int64_t> held_ns;
  std::uint64_t twice = 0;  // number of the other end's samples that came more than once
};

/// Agrees with a PathResponder at `host` on that stream and records it. This takes terms.samples /
/// terms.rate_hz seconds, and up to some seconds before and after. Errors say why there is no
/// record and what to do; an error also comes when `stop` is set.
Result<RecordedPath> RecordPath(const std::string& host, std::uint16_t port, const PathTerms& terms,
                                const std::atomic<bool>& stop);

}  // namespace tandem
