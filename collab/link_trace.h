#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace tandem {

/// A sample of a trace, in the order of sending.
struct TracedSample {
  float delay_ms = 0;      // one way; below 0: it never arrived
  bool overtaken = false;  // a sample that was sent later arrived earlier

  bool lost() const noexcept { return delay_ms < 0; }
};

/// What the ages of a trace come to, held as a receiver holds the newest sample that it has.
struct TraceFacts {
  double loss = 0;           // share of samples that never arrived
  double overtaken = 0;      // share of those that arrived
  double mean_delay_ms = 0;  // of those that arrived
  double longest_ms = 0;     // delay
  /// The time since the newest sample that has arrived was sent: mean over time, and the most.
  double mean_age_ms = 0;
  double peak_age_ms = 0;
};

/// What one way of a line did to samples that were sent at a constant rate: the network of a run,
/// played again (docs/network-plans.md). Never changed once it is made, so that threads share it.
class LinkTrace {
 public:
  /// `delay_ms`: of each sample, below 0 where it was lost; at least one. Every delay is multiplied
  /// by `stretch`.
  LinkTrace(double rate_hz, const std::vector<float>& delay_ms, double stretch = 1);

  double rate_hz() const noexcept { return rate_hz_; }
  double seconds() const noexcept { return static_cast<double>(samples_.size()) / rate_hz_; }
  const std::vector<TracedSample>& samples() const noexcept { return samples_; }
  const TraceFacts& facts() const noexcept { return facts_; }

  /// The sample that was sent last at `elapsed_ns` from the trace's begin. The trace begins again
  /// where it ends, and has no beginning: a time before 0 is one before the trace's end.
  const TracedSample& At(std::int64_t elapsed_ns) const noexcept;

  /// Where it is from, so that a run can be described: a trace's file, or a model's name.
  struct Source {
    std::string file;
    std::string model;
    bool back = false;  // the way back of what the source has
    double stretch = 1;
  };
  Source source;

 private:
  double rate_hz_;
  std::vector<TracedSample> samples_;
  TraceFacts facts_;
};

}  // namespace tandem
