#include "collab/simulated/network/box_gap.h"

#include <algorithm>

namespace tandem {

double BoxGap(const SolidBox& a, const SolidBox& b) {
  const Mat3 A = a.X_WB.q.toRotationMatrix();
  const Mat3 B = b.X_WB.q.toRotationMatrix();
  const Vec3 between = b.X_WB.p - a.X_WB.p;
  double gap = -1e9;
  const auto look_along = [&](const Vec3& axis) {
    const double length = axis.norm();
    if (length < 1e-9) return;
    const Vec3 n = axis / length;
    const double reach =
        (A.transpose() * n).cwiseAbs().dot(a.half) + (B.transpose() * n).cwiseAbs().dot(b.half);
    gap = std::max(gap, std::abs(n.dot(between)) - reach);
  };
  for (int i = 0; i < 3; ++i) {
    look_along(A.col(i));
    look_along(B.col(i));
    for (int j = 0; j < 3; ++j) look_along(A.col(i).cross(B.col(j)));
  }
  return gap;
}

}  // namespace tandem
