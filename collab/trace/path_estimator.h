#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "collab/session/messages.h"
#include "collab/trace/path_record.h"

namespace tandem {

/// The line to one other peer, from the messages that this peer heard of it in a session. Way back:
/// the other's samples, by their numbers and stamps. Way there: our samples; the other says which
/// one is the newest that it has. Arrivals are exact to a frame, 1 ms: neither end looks more
/// often.
class PathEstimator {
 public:
  explicit PathEstimator(PeerId self) : self_(self) {}

  /// Takes states in the order in which our frames took them; `now_ns`: our clock.
  void Add(const ObjectState& state, std::int64_t now_ns);
  void Add(const CouplingLinks& links);
  std::size_t states() const noexcept { return samples_.size(); }

  struct Estimate {
    /// Record of the longest time in which states came without a pause of more than two seconds. A
    /// longer pause may be due to the line or to an empty hand. An own sample that is never named
    /// as the newest is taken to arrive with the next that is: it is as old as the other peer found
    /// it. It counts as lost only if that is two seconds later than the least delay.
    PathRecord record;
    bool has_echoes = false;  // false: `there_ns` has nothing
    double seconds = 0;
  };
  /// Returns the line; nullopt: fewer than ten states came in a row.
  std::optional<Estimate> EstimatePath() const;

 private:
  struct Sample {
    std::uint32_t seq = 0;
    std::int64_t sent_ns = 0;  // the other's clock
    std::int64_t received_ns = 0;
  };
  struct Echo {
    std::int64_t own_ns = 0;   // our stamp
    std::int64_t said_ns = 0;  // the other's clock: our sample was there by then
  };
  std::vector<Sample> LongestRun() const;
  void EstimateForwardPath(std::int64_t first_ns, std::int64_t period_ns, PathRecord& record) const;

  PeerId self_;
  std::vector<Sample> samples_;
  std::vector<Echo> echoes_;  // each with a newer stamp than the ones before
};

}  // namespace tandem
