#include "collab/trace/path_estimator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "collab/trace/trace_file.h"
#include "engine/base/units.h"

namespace tandem {

namespace {

constexpr std::int64_t kPauseNs = 2'000'000'000;
constexpr std::int64_t kFrameNs = 1'000'000;
constexpr std::size_t kLeastSamples = 10;

}  // namespace

void PathEstimator::Add(const ObjectState& state, std::int64_t now_ns) {
  // parked states come five times a second, and states of loose bodies beside those of the held one
  if ((state.flags & (kStateParked | kStateLoose)) != 0) return;
  if (samples_.size() < kMostTraceSamples) {
    samples_.push_back({state.seq, state.sample_ns, now_ns});
  }
}

void PathEstimator::Add(const CouplingLinks& links) {
  for (const LinkEntry& entry :
       std::span(links.entries).first(std::min<std::size_t>(links.count, kMaxLinks))) {
    if (entry.to != self_ || entry.echo_ns == 0) continue;
    if (!echoes_.empty() && entry.echo_ns <= echoes_.back().own_ns) {
      // the links that said it first may come after later ones
      const auto same =
          std::ranges::find(echoes_.rbegin(), echoes_.rend(), entry.echo_ns, &Echo::own_ns);
      if (same != echoes_.rend()) same->said_ns = std::min(same->said_ns, links.sample_ns);
      continue;
    }
    if (echoes_.size() < kMostTraceSamples) echoes_.push_back({entry.echo_ns, links.sample_ns});
  }
}

std::vector<PathEstimator::Sample> PathEstimator::LongestRun() const {
  std::vector<Sample> sorted = samples_;
  // the first arrival of duplicates counts
  std::ranges::stable_sort(sorted, {}, &Sample::sent_ns);
  // clang 14 does not compile std::ranges::unique of this library
  sorted.erase(std::unique(sorted.begin(), sorted.end(),
                           [](const Sample& a, const Sample& b) {
                             return a.sent_ns == b.sent_ns;
                           }),
               sorted.end());
  std::size_t begin = 0;
  std::size_t best = 0;
  std::size_t best_end = 0;
  for (std::size_t i = 1; i <= sorted.size(); ++i) {
    const bool on = i < sorted.size() && sorted[i].sent_ns - sorted[i - 1].sent_ns <= kPauseNs &&
                    sorted[i].seq > sorted[i - 1].seq;
    if (on) continue;
    if (i - begin > best_end - best) {
      best = begin;
      best_end = i;
    }
    begin = i;
  }
  return {sorted.begin() + static_cast<std::ptrdiff_t>(best),
          sorted.begin() + static_cast<std::ptrdiff_t>(best_end)};
}

std::optional<PathEstimator::Estimate> PathEstimator::EstimatePath() const {
  const std::vector<Sample> run = LongestRun();
  if (run.size() < kLeastSamples) return std::nullopt;
  // numbers count the sender's frames; a quarter of the steps are no longer than without loss
  std::vector<std::uint32_t> steps;
  for (std::size_t i = 1; i < run.size(); ++i) steps.push_back(run[i].seq - run[i - 1].seq);
  const auto quarter = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 4);
  std::ranges::nth_element(steps, quarter);
  const std::uint32_t step = std::max(1U, *quarter);

  const std::size_t count = (run.back().seq - run.front().seq) / step + 1;
  if (count > kMostTraceSamples) return std::nullopt;
  Estimate found;
  const double frames_s = ToSeconds(kFrameNs);
  found.record.rate_hz = 1.0 / (frames_s * step);
  found.record.back_ns.assign(count, PathRecord::kNever);
  found.record.there_ns.assign(count, PathRecord::kNever);
  for (const Sample& sample : run) {
    std::int64_t& place = found.record.back_ns[(sample.seq - run.front().seq) / step];
    if (place == PathRecord::kNever) place = sample.received_ns - sample.sent_ns;
  }
  EstimateForwardPath(run.front().sent_ns, kFrameNs * step, found.record);
  found.seconds = static_cast<double>(found.record.back_ns.size()) / found.record.rate_hz;
  found.has_echoes = std::ranges::any_of(found.record.there_ns, [](std::int64_t ns) {
    return ns != PathRecord::kNever;
  });
  return found;
}

void PathEstimator::EstimateForwardPath(std::int64_t first_ns, std::int64_t period_ns,
                                        PathRecord& record) const {
  // our clock at the record's begin: the other's clock less its offset, as far as known
  std::int64_t there = std::numeric_limits<std::int64_t>::max();
  std::int64_t back = there;
  for (const Echo& echo : echoes_) there = std::min(there, echo.said_ns - echo.own_ns);
  for (const std::int64_t ns : record.back_ns) {
    if (ns != PathRecord::kNever) back = std::min(back, ns);
  }
  if (echoes_.empty()) return;
  const std::int64_t own_first_ns = first_ns - (there - back) / 2;
  // our samples that were the newest there, each in its period
  std::vector<std::int64_t>& there_ns = record.there_ns;
  std::size_t known = 0;
  for (const Echo& echo : echoes_) {
    const std::int64_t period = (echo.own_ns - own_first_ns) / period_ns;
    if (echo.own_ns < own_first_ns || period >= static_cast<std::int64_t>(there_ns.size()))
      continue;
    std::int64_t& place = there_ns[static_cast<std::size_t>(period)];
    if (place == PathRecord::kNever) place = echo.said_ns - echo.own_ns;
    known = static_cast<std::size_t>(period) + 1;
  }
  if (known == 0) return;
  // the other end said nothing of the last ones
  there_ns.resize(known);
  record.back_ns.resize(known);
  // a sample that was never the newest came with the next that was
  for (std::size_t i = known - 1; i-- > 0;) {
    if (there_ns[i] != PathRecord::kNever) continue;
    const std::int64_t with_next =
        there_ns[i + 1] == PathRecord::kNever ? PathRecord::kNever : there_ns[i + 1] + period_ns;
    if (with_next != PathRecord::kNever && with_next - there < kPauseNs) there_ns[i] = with_next;
  }
  // stamps lie anywhere in their periods; each newest sample came after the one before
  for (std::size_t i = 1; i < known; ++i) {
    if (there_ns[i] == PathRecord::kNever || there_ns[i - 1] == PathRecord::kNever) continue;
    there_ns[i] = std::max(there_ns[i], there_ns[i - 1] - period_ns);
  }
}

}  // namespace tandem
