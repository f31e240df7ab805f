#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "collab/messages.h"
#include "collab/trace/line_record.h"

namespace tandem {

/// The line to one other peer, from what a peer heard of it in a session. Way back: the other's
/// samples, by their numbers and stamps. Way there: our samples, of which the other says which is
/// the newest that it holds. Arrivals are known to a frame, 1 ms: neither end looks more often.
class HeardLine {
 public:
  explicit HeardLine(PeerId self) : self_(self) {}

  /// In the order in which our frames took them; `now_ns`: our clock.
  void Heard(const ObjectState& state, std::int64_t now_ns);
  void Heard(const CouplingLinks& links);
  std::size_t states() const noexcept { return samples_.size(); }

  struct Found {
    /// Of the longest time in which states came without a pause of more than two seconds: nobody
    /// can tell whether a longer one is the line's or an empty hand's. What of ours is never named
    /// as the newest is taken to arrive with the next that is: so nothing is lost there, and it is
    /// as old as the other found it.
    LineRecord record;
    bool has_echoes = false;  // else `there_ns` has nothing
    double seconds = 0;
  };
  /// Nothing: fewer than ten states came in a row.
  std::optional<Found> Find() const;

 private:
  struct Sample {
    std::uint32_t seq = 0;
    std::int64_t sent_ns = 0;  // the other's clock
    std::int64_t heard_ns = 0;
  };
  struct Echo {
    std::int64_t own_ns = 0;   // our stamp
    std::int64_t said_ns = 0;  // the other's clock: it was there by then
  };
  std::vector<Sample> LongestRun() const;
  void FindThere(std::int64_t first_ns, std::int64_t period_ns, LineRecord& record) const;

  PeerId self_;
  std::vector<Sample> samples_;
  std::vector<Echo> echoes_;  // each of a newer stamp than those before
};

}  // namespace tandem
