#pragma once

#include "collab/session/messages.h"

namespace tandem {

/// Returns whether counter `a` comes after `b`; counters wrap.
inline bool IsAfter(std::uint32_t a, std::uint32_t b) noexcept {
  return static_cast<std::int32_t>(a - b) > 0;
}

/// Returns whether state `a` is newer than `b` of the same instance: by epoch, then by number.
inline bool IsNewer(const ObjectState& a, const ObjectState& b) noexcept {
  return IsAfter(a.epoch, b.epoch) || (a.epoch == b.epoch && IsAfter(a.seq, b.seq));
}

}  // namespace tandem
