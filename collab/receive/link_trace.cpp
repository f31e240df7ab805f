#include "collab/receive/link_trace.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/base/check.h"
#include "engine/base/units.h"

namespace tandem {

namespace {

// delays are exact to a microsecond: arrivals within two are simultaneous
constexpr double kAlikeMs = 2e-3;

/// Marks each sample that a later one has overtaken.
void MarkOvertaken(double period_ms, std::vector<TracedSample>& samples) {
  double earliest_ms = std::numeric_limits<double>::infinity();  // arrival of samples sent later
  for (std::size_t i = samples.size(); i-- > 0;) {
    if (samples[i].lost()) continue;
    const double arrival_ms =
        period_ms * static_cast<double>(i) + static_cast<double>(samples[i].delay_ms);
    samples[i].overtaken = earliest_ms < arrival_ms - kAlikeMs;
    earliest_ms = std::min(earliest_ms, arrival_ms);
  }
}

/// Ages of the newest sample held: from its delay at arrival they rise with time, until a newer one
/// arrives.
class Ages {
 public:
  /// Takes a sample that is newer than all earlier ones.
  void Arrives(double sent_ms, double arrival_ms) {
    if (begun_) Hold(arrival_ms);
    begun_ = true;
    sent_ms_ = sent_ms;
    since_ms_ = arrival_ms;
  }
  double mean_ms() const { return time_ms_ > 0 ? area_ / time_ms_ : 0.0; }
  double peak_ms() const { return peak_ms_; }

 private:
  void Hold(double until_ms) {
    const double time_ms = until_ms - since_ms_;
    const double oldest_ms = until_ms - sent_ms_;
    area_ += time_ms * (oldest_ms - 0.5 * time_ms);
    time_ms_ += time_ms;
    peak_ms_ = std::max(peak_ms_, oldest_ms);
  }

  bool begun_ = false;
  double sent_ms_ = 0;
  double since_ms_ = 0;
  double time_ms_ = 0;
  double area_ = 0;  // ms^2
  double peak_ms_ = 0;
};

TraceFacts FactsOf(double period_ms, const std::vector<TracedSample>& samples) {
  TraceFacts facts;
  Ages ages;
  std::size_t arrived = 0;
  std::size_t overtaken = 0;
  // twice in a row, as a trace is played: the last sample is held until the first arrives again. An
  // overtaken sample is never the newest that the receiver has.
  for (std::size_t i = 0; i < 2 * samples.size(); ++i) {
    const TracedSample& sample = samples[i % samples.size()];
    if (sample.lost()) continue;
    const double sent_ms = period_ms * static_cast<double>(i);
    const auto delay_ms = static_cast<double>(sample.delay_ms);
    if (!sample.overtaken) ages.Arrives(sent_ms, sent_ms + delay_ms);
    if (i >= samples.size()) continue;
    ++arrived;
    overtaken += sample.overtaken ? 1 : 0;
    facts.mean_delay_ms += delay_ms;
    facts.longest_ms = std::max(facts.longest_ms, delay_ms);
  }
  const auto sent = static_cast<double>(samples.size());
  facts.loss = 1.0 - static_cast<double>(arrived) / sent;
  if (arrived > 0) {
    facts.mean_delay_ms /= static_cast<double>(arrived);
    facts.overtaken = static_cast<double>(overtaken) / static_cast<double>(arrived);
  }
  facts.mean_age_ms = ages.mean_ms();
  facts.peak_age_ms = ages.peak_ms();
  return facts;
}

}  // namespace

LinkTrace::LinkTrace(double rate_hz, const std::vector<float>& delay_ms, double stretch)
    : rate_hz_(rate_hz) {
  TANDEM_CHECK(rate_hz > 0 && !delay_ms.empty() && stretch >= 0);
  source.stretch = stretch;
  samples_.reserve(delay_ms.size());
  for (const float delay : delay_ms) {
    const double late = stretch * static_cast<double>(delay);
    samples_.push_back({.delay_ms = delay < 0 ? -1.0F : static_cast<float>(late)});
  }
  const double period_ms = 1e3 / rate_hz_;
  MarkOvertaken(period_ms, samples_);
  facts_ = FactsOf(period_ms, samples_);
}

const TracedSample& LinkTrace::At(std::int64_t elapsed_ns) const noexcept {
  const auto length = static_cast<std::int64_t>(samples_.size());
  const auto sent = static_cast<std::int64_t>(std::floor(ToSeconds(elapsed_ns) * rate_hz_ + 1e-6));
  const std::int64_t index = sent % length;
  return samples_[static_cast<std::size_t>(index < 0 ? index + length : index)];
}

}  // namespace tandem
