#pragma once

#include <algorithm>
#include <cmath>

#include "collab/controller/requests.h"
#include "engine/base/spatial.h"

namespace tandem {

/// Convert the engine's values to a host's plain ones and back.
inline std::array<double, 3> Plain(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}
inline PlainPose Plain(const Pose& X) {
  return {Plain(X.p), {X.q.x(), X.q.y(), X.q.z(), X.q.w()}};
}
inline Vec3 AsVec3(const std::array<double, 3>& v) {
  return {v[0], v[1], v[2]};
}
inline Pose AsPose(const PlainPose& X) {
  return {Quat(X.q_W[3], X.q_W[0], X.q_W[1], X.q_W[2]), AsVec3(X.p_W)};
}

/// Returns whether all three numbers are plausible as metres, newtons or rates.
template <typename Three>
bool AllFinite(const Three& v) {
  return std::all_of(v.begin(), v.end(), [](double x) {
    return std::isfinite(x) && std::abs(x) < 1e3;
  });
}

}  // namespace tandem
