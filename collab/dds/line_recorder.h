#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "collab/dds/line_messages.h"
#include "collab/trace/line_record.h"
#include "engine/base/result.h"

namespace tandem {

/// A line as both of its ends saw it for a while.
struct RecordedLine {
  std::string address;
  LineRecord record;
  /// Of each sample that came back, ns: now minus the newest own sending that the other end held,
  /// and how long it had held that. The difference is a round trip.
  std::vector<std::int64_t> loop_age_ns;
  std::vector<std::int64_t> held_ns;
  std::uint64_t twice = 0;  // samples of the other end that came more than once
};

/// Agrees with a LineAnswerer at `host` on that stream and records it: takes terms.samples /
/// terms.rate_hz seconds, and up to some seconds before and after. Errors: why there is no record,
/// and what to do; `stop` was set.
Result<RecordedLine> RecordLine(const std::string& host, std::uint16_t port, const LineTerms& terms,
                                const std::atomic<bool>& stop);

}  // namespace tandem
