#include "engine/safety/mean_limit.h"

#include <algorithm>

#include "engine/base/units.h"

namespace tandem {

MeanLimit::MeanLimit(double continuous, double peak) noexcept
    : continuous_(continuous), peak_(peak) {}

double MeanLimit::Allowed() const noexcept {
  if (continuous_ >= peak_) return peak_;
  const double budget = ToSeconds(kWindowNs) * continuous_;
  if (!(budget > 0)) return 0.0;
  const double left = std::max(0.0, budget - sum_);
  return peak_ * std::min(1.0, left / (kFadeShare * budget));
}

void MeanLimit::RecordForce(double size, std::int64_t for_ns) noexcept {
  // a time longer than the window fills it
  for_ns = std::clamp<std::int64_t>(for_ns, 0, kWindowNs);
  while (for_ns > 0) {
    const std::int64_t part_ns = std::min(for_ns, kSlotNs - in_slot_ns_);
    slots_[slot_] += ToSeconds(part_ns) * size;
    sum_ += ToSeconds(part_ns) * size;
    in_slot_ns_ += part_ns;
    for_ns -= part_ns;
    if (in_slot_ns_ < kSlotNs) break;
    in_slot_ns_ = 0;
    slot_ = (slot_ + 1) % slots_.size();
    slots_[slot_] = 0;
    sum_ = 0;
    for (const double slot : slots_) sum_ += slot;
  }
}

}  // namespace tandem
