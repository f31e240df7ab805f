#pragma once

#include "collab/messages.h"
#include "collab/planted_faults.h"

namespace tandem {

/// Whether counter a comes after b, counters that wrap included.
inline bool IsAfter(std::uint32_t a, std::uint32_t b) noexcept {
  return static_cast<std::int32_t>(a - b) > 0;
}

/// Whether a state was taken after another of the same instance: by grab, then by number.
inline bool IsNewer(const ObjectState& a, const ObjectState& b) noexcept {
  if (Planted(Fault::kStaleState)) return !IsAfter(a.seq, b.seq);
  return IsAfter(a.epoch, b.epoch) || (a.epoch == b.epoch && IsAfter(a.seq, b.seq));
}

}  // namespace tandem
