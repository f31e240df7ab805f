#pragma once

#include "engine/base/spatial.h"

namespace tandem {

/// Returns `v`, shortened to `most` in its direction; sets `cut` if that was needed. A finite
/// vector stays finite.
inline Vec3 ClampLength(const Vec3& v, double most, bool& cut) noexcept {
  const double size = v.stableNorm();
  if (size <= most) return v;
  cut = true;
  return (most * v.cwiseQuotient(Vec3::Constant(size)));
}

/// Returns a step from `from` towards `to`, of at most `most`.
inline Vec3 StepTowards(const Vec3& from, const Vec3& to, double most, bool& cut) noexcept {
  return from + ClampLength(to - from, most, cut);
}

}  // namespace tandem
