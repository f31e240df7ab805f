#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace tandem {

/// A sample of a trace, in the order of sending.
struct TracedSample {
  float delay_ms = 0;      // one-way delay; below 0: the sample never arrived
  bool overtaken = false;  // a sample sent later arrived earlier

  bool lost() const noexcept { return delay_ms < 0; }
};

/// Statistics of a trace. The ages are those of the newest sample that a receiver has.
struct TraceFacts {
  double loss = 0;           // share of samples lost
  double overtaken = 0;      // share of arrived samples that were overtaken
  double mean_delay_ms = 0;  // mean over the arrived samples
  double longest_ms = 0;     // longest delay
  /// Time since the newest arrived sample was sent: mean over time, and maximum.
  double mean_age_ms = 0;
  double peak_age_ms = 0;
};

/// One direction of a line, recorded as the fate of samples sent at a constant rate. A link
/// conditioner plays it again (docs/network-plans.md). Immutable, so that threads share it.
class LinkTrace {
 public:
  /// `delay_ms`: delay of each sample, below 0 where it was lost; at least one sample. `stretch`:
  /// factor on every delay.
  LinkTrace(double rate_hz, const std::vector<float>& delay_ms, double stretch = 1);

  double rate_hz() const noexcept { return rate_hz_; }
  double seconds() const noexcept { return static_cast<double>(samples_.size()) / rate_hz_; }
  const std::vector<TracedSample>& samples() const noexcept { return samples_; }
  const TraceFacts& facts() const noexcept { return facts_; }

  /// Returns the last sample sent by `elapsed_ns` from the trace's begin. The trace repeats without
  /// end in both directions: a time before 0 lies before the trace's end.
  const TracedSample& At(std::int64_t elapsed_ns) const noexcept;

  /// Origin of the trace, so that a run can be described: a trace's file, or a model's name.
  struct Source {
    std::string file;
    std::string model;
    bool back = false;  // the way back of the source
    double stretch = 1;
  };
  Source source;

 private:
  double rate_hz_;
  std::vector<TracedSample> samples_;
  TraceFacts facts_;
};

}  // namespace tandem
