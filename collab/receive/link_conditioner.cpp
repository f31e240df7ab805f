#include "collab/receive/link_conditioner.h"

#include <algorithm>
#include <cmath>

#include "engine/base/units.h"

namespace tandem {

namespace {

constexpr double kTwoPi = 6.283185307179586;

/// Makes neighbouring seeds give unlike streams (splitmix64).
std::uint64_t Mixed(std::uint64_t seed) {
  seed += 0x9E3779B97F4A7C15U;
  seed = (seed ^ (seed >> 30U)) * 0xBF58476D1CE4E5B9U;
  seed = (seed ^ (seed >> 27U)) * 0x94D049BB133111EBU;
  return seed ^ (seed >> 31U);
}

std::int64_t Ns(double ms) {
  return std::llround(1e6 * ms);
}

}  // namespace

LinkConditioner::LinkConditioner(const LinkConditions& conditions, std::uint64_t stream)
    : conditions_(conditions), stream_(stream), random_(Mixed(Mixed(conditions.seed) ^ stream)) {}

void LinkConditioner::Switch(const LinkConditions& conditions) noexcept {
  if (conditions.seed != conditions_.seed) random_.seed(Mixed(Mixed(conditions.seed) ^ stream_));
  if (conditions.trace != conditions_.trace ||
      conditions.trace_start_s != conditions_.trace_start_s) {
    trace_begun_ = false;
  }
  conditions_ = conditions;
}

const TracedSample* LinkConditioner::Traced(std::int64_t arrival_ns) noexcept {
  if (conditions_.trace == nullptr) return nullptr;
  if (!trace_begun_) trace_begin_ns_ = arrival_ns;
  trace_begun_ = true;
  return &conditions_.trace->At(arrival_ns - trace_begin_ns_ + Ns(1e3 * conditions_.trace_start_s));
}

double LinkConditioner::Random() noexcept {
  return static_cast<double>(random_() >> 11U) * 0x1p-53;
}

bool LinkConditioner::Lost() noexcept {
  if (conditions_.burst_enter > 0) {
    in_burst_ =
        in_burst_ ? Random() >= conditions_.burst_leave : Random() < conditions_.burst_enter;
  } else {
    in_burst_ = false;
  }
  if (in_burst_ && Random() < conditions_.burst_loss) return true;
  return conditions_.loss > 0 && Random() < conditions_.loss;
}

std::size_t LinkConditioner::Due(std::int64_t arrival_ns,
                                 std::array<std::int64_t, 2>& due_ns) noexcept {
  const TracedSample* const traced = Traced(arrival_ns);
  if (Lost() || conditions_.cut || (traced != nullptr && traced->lost())) return 0;
  double delay_ms = conditions_.delay_ms;
  if (traced != nullptr) delay_ms += static_cast<double>(traced->delay_ms);
  if (conditions_.swing_ms > 0) {
    const double turns = ToSeconds(arrival_ns) / conditions_.swing_period_s;
    delay_ms += conditions_.swing_ms * std::sin(kTwoPi * (turns - std::floor(turns)));
  }
  if (conditions_.jitter_ms > 0) delay_ms += conditions_.jitter_ms * Random();
  const std::int64_t due = arrival_ns + Ns(std::max(0.0, delay_ms));
  if (traced != nullptr && traced->overtaken) {
    // the sample does not wait for earlier ones, and later ones do not wait for it
    due_ns[0] = due;
  } else if (conditions_.reorder > 0 && Random() < conditions_.reorder) {
    // later samples do not wait for it
    due_ns[0] = std::max(latest_due_ns_, due) + Ns(conditions_.reorder_ms * Random());
  } else {
    latest_due_ns_ = std::max(latest_due_ns_, due);
    due_ns[0] = latest_due_ns_;
  }
  if (conditions_.duplicate <= 0 || Random() >= conditions_.duplicate) return 1;
  due_ns[1] = due_ns[0] + Ns(1.0 + std::max(conditions_.jitter_ms, 1.0) * Random());
  return 2;
}

}  // namespace tandem
