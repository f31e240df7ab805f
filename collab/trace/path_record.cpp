#include "collab/trace/path_record.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "collab/trace/trace_file.h"

namespace tandem {

namespace {

constexpr std::size_t kLeastWindows = 10;  // windows of a second; fewest for a drift
constexpr std::size_t kMostWindows = 600;

/// Returns the least value from `begin` to `end`; nullopt: all samples were lost.
std::optional<double> LeastOf(const std::vector<std::int64_t>& ns, std::size_t begin,
                              std::size_t end) {
  std::int64_t least = std::numeric_limits<std::int64_t>::max();
  for (std::size_t i = begin; i < std::min(end, ns.size()); ++i) {
    if (ns[i] != PathRecord::kNever) least = std::min(least, ns[i]);
  }
  if (least == std::numeric_limits<std::int64_t>::max()) return std::nullopt;
  return static_cast<double>(least);
}

double MedianOf(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Seen {
  double t_s = 0;
  double offset_ns = 0;  // from the least delays of a window
};

/// Returns the drift in ns/s that most pairs of windows agree on (Theil and Sen); 0 where its
/// effect over the record does not exceed the scatter of the windows.
double DriftOf(const std::vector<Seen>& windows) {
  if (windows.size() < kLeastWindows) return 0;
  std::vector<double> slopes;
  for (std::size_t i = 0; i < windows.size(); ++i) {
    for (std::size_t j = i + 1; j < windows.size(); ++j) {
      slopes.push_back((windows[j].offset_ns - windows[i].offset_ns) /
                       (windows[j].t_s - windows[i].t_s));
    }
  }
  const double slope = MedianOf(slopes);
  std::vector<double> rest;
  for (const Seen& each : windows) rest.push_back(each.offset_ns - slope * each.t_s);
  const double middle = MedianOf(rest);
  for (double& each : rest) each = std::abs(each - middle);
  const double made = std::abs(slope) * (windows.back().t_s - windows.front().t_s);
  return made > 4.0 * MedianOf(rest) ? slope : 0.0;
}

/// Returns the record without the drift.
std::vector<std::int64_t> Straight(const std::vector<std::int64_t>& ns, double rate_hz,
                                   double drift_ns_s) {
  std::vector<std::int64_t> straight = ns;
  for (std::size_t i = 0; i < straight.size(); ++i) {
    if (straight[i] == PathRecord::kNever) continue;
    straight[i] -= std::llround(drift_ns_s * static_cast<double>(i) / rate_hz);
  }
  return straight;
}

float DelayOf(std::int64_t ns, std::int64_t offset_ns) {
  if (ns == PathRecord::kNever) return NetworkTrace::kLost;
  return AsInFile(std::clamp(1e-6 * static_cast<double>(ns - offset_ns), 0.0, kLongestTracedMs));
}

}  // namespace

ClockEstimate EstimateClocks(const PathRecord& record) {
  const std::size_t samples = std::min(record.there_ns.size(), record.back_ns.size());
  const auto window = static_cast<std::size_t>(
      std::max(std::ceil(record.rate_hz), std::ceil(static_cast<double>(samples) / kMostWindows)));
  std::vector<Seen> windows;
  for (std::size_t begin = 0; begin + window <= samples; begin += window) {
    const auto there = LeastOf(record.there_ns, begin, begin + window);
    const auto back = LeastOf(record.back_ns, begin, begin + window);
    if (!there || !back) continue;
    windows.push_back(
        {static_cast<double>(begin + window / 2) / record.rate_hz, 0.5 * (*there - *back)});
  }
  const double drift_ns_s = DriftOf(windows);
  const auto there = LeastOf(Straight(record.there_ns, record.rate_hz, drift_ns_s), 0, samples);
  const auto back = LeastOf(Straight(record.back_ns, record.rate_hz, -drift_ns_s), 0, samples);
  if (!there || !back) return {.bound_ms = -1};
  return {.offset_ns = std::llround(0.5 * (*there - *back)),
          .drift_ppm = 1e-3 * drift_ns_s,
          .bound_ms = 0.5e-6 * (*there + *back)};
}

NetworkTrace TraceOf(const PathRecord& record, const ClockEstimate& clocks) {
  const double drift_ns_s = 1e3 * clocks.drift_ppm;
  NetworkTrace trace{.rate_hz = record.rate_hz};
  for (const std::int64_t ns : Straight(record.there_ns, record.rate_hz, drift_ns_s)) {
    trace.there_ms.push_back(DelayOf(ns, clocks.offset_ns));
  }
  for (const std::int64_t ns : Straight(record.back_ns, record.rate_hz, -drift_ns_s)) {
    trace.back_ms.push_back(DelayOf(ns, -clocks.offset_ns));
  }
  trace.clock_bound_ms = clocks.bound_ms;
  return trace;
}

}  // namespace tandem
