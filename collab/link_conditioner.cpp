#include "collab/link_conditioner.h"

#include <algorithm>
#include <cmath>

namespace tandem {

LinkConditioner::LinkConditioner(const LinkConditions& conditions)
    : conditions_(conditions), random_(conditions.seed) {}

double LinkConditioner::Random() noexcept {
  return static_cast<double>(random_() >> 11U) * 0x1p-53;
}

std::optional<std::int64_t> LinkConditioner::Due(std::int64_t arrival_ns) noexcept {
  if (conditions_.loss > 0 && Random() < conditions_.loss) return std::nullopt;
  double delay_ms = conditions_.delay_ms;
  if (conditions_.jitter_ms > 0) delay_ms += conditions_.jitter_ms * Random();
  latest_due_ns_ =
      std::max<std::int64_t>(latest_due_ns_, arrival_ns + std::llround(delay_ms * 1e6));
  return latest_due_ns_;
}

}  // namespace tandem
