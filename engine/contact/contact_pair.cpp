#include "engine/contact/contact_pair.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/base/check.h"

namespace tandem {

namespace {

/// Vectors and matrices about a point, turned from V to W.
Load Turned(const Load& load_V, const Mat3& R_WV) {
  Mat6 R = Mat6::Zero();
  R.topLeftCorner<3, 3>() = R_WV;
  R.bottomRightCorner<3, 3>() = R_WV;
  return {R * load_V.force, R * load_V.stiffness * R.transpose(),
          R * load_V.damping * R.transpose()};
}

}  // namespace

ContactPair::ContactPair(const Pointshell& shell, const Voxmap& voxmap, const Pose& X_BV,
                         int force_layer, const ContactGains& gains)
    : shell_(&shell), voxmap_(&voxmap), X_BV_(X_BV), force_layer_(force_layer), gains_(gains) {
  TANDEM_CHECK(force_layer >= 0 && force_layer <= voxmap.range() - 2);
  found_.resize(shell.size());
}

bool ContactPair::MayMeet(const Pose& X_VS) const noexcept {
  const Vec3 nearest = X_VS.p.cwiseMax(Vec3::Zero()).cwiseMin(voxmap_->extent());
  return (X_VS.p - nearest).norm() <= shell_->radius;
}

void ContactPair::FindPoints(const Pose& X_VS, int threshold) noexcept {
  // p in voxels = A p_B + b, in blocks so that the arithmetic runs over arrays
  constexpr std::size_t kBlock = 256;
  const Mat3 R = X_VS.q.toRotationMatrix() / voxmap_->voxel_size();
  const Vec3 t = X_VS.p / voxmap_->voxel_size();
  std::array<float, 9> a{};
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 3; ++col) {
      a[static_cast<std::size_t>(3 * row + col)] = static_cast<float>(R(row, col));
    }
  }
  const auto b0 = static_cast<float>(t.x());
  const auto b1 = static_cast<float>(t.y());
  const auto b2 = static_cast<float>(t.z());
  std::array<std::int32_t, kBlock> ix;
  std::array<std::int32_t, kBlock> iy;
  std::array<std::int32_t, kBlock> iz;
  found_count_ = 0;
  const std::size_t size = shell_->size();
  for (std::size_t begin = 0; begin < size; begin += kBlock) {
    const std::size_t count = std::min(kBlock, size - begin);
    const float* x = shell_->x.data() + begin;
    const float* y = shell_->y.data() + begin;
    const float* z = shell_->z.data() + begin;
    for (std::size_t i = 0; i < count; ++i) {
      // +1 and -1 make truncation round down for the band of voxels just below 0 too; lower ones
      // are outside
      const float u = a[0] * x[i] + a[1] * y[i] + a[2] * z[i] + b0;
      const float v = a[3] * x[i] + a[4] * y[i] + a[5] * z[i] + b1;
      const float w = a[6] * x[i] + a[7] * y[i] + a[8] * z[i] + b2;
      ix[i] = static_cast<std::int32_t>(u + 1.0F) - 1;
      iy[i] = static_cast<std::int32_t>(v + 1.0F) - 1;
      iz[i] = static_cast<std::int32_t>(w + 1.0F) - 1;
    }
    for (std::size_t i = 0; i < count; ++i) {
      const GridIndex voxel{ix[i], iy[i], iz[i]};
      const int value = voxmap_->Value(Field::kSurface, voxel);
      found_[found_count_] = {static_cast<std::uint32_t>(begin + i), voxel, value};
      found_count_ += value <= threshold ? 1U : 0U;
    }
  }
}

void ContactPair::AddForces(const Pose& X_VS, const BodyMotion& shell_body,
                            const BodyMotion& map_body, const Pose& X_WV, PairReport& report,
                            Load& on_shell, Load& on_map) const noexcept {
  const double s = voxmap_->voxel_size();
  const Quat q_VW = X_WV.q.conjugate();
  const Vec3 p_VS = X_VS.p;                            // shell body's centre of mass
  const Vec3 p_VM = X_WV.Inverse() * map_body.X_WB.p;  // voxmap body's
  const Vec3 w_shell = q_VW * shell_body.V_WB.w;
  const Vec3 v_shell = q_VW * shell_body.V_WB.v;
  const Vec3 w_map = q_VW * map_body.V_WB.w;
  const Vec3 v_map = q_VW * map_body.V_WB.v;
  const Mat3 R_VS = X_VS.q.toRotationMatrix();
  Load shell_V;
  Load map_V;
  for (std::size_t i = 0; i < found_count_; ++i) {
    const Found& found = found_[i];
    if (found.value > 2 + force_layer_) continue;
    ++report.contact_points;
    const Vec3 p = R_VS * shell_->point(found.point) + p_VS;
    const Vec3 n = R_VS * shell_->normal(found.point);
    const Vec3 centre =
        s * (Vec3(found.voxel.x, found.voxel.y, found.voxel.z) + Vec3::Constant(0.5));
    const double depth = TangentPlaneDepth(p, centre, n, found.value, force_layer_, s);
    if (depth <= 0) continue;
    ++report.loaded_points;
    const Vec3 r_shell = p - p_VS;
    const Vec3 r_map = p - p_VM;
    const double approach = -n.dot(v_shell + w_shell.cross(r_shell) - v_map - w_map.cross(r_map));
    // contact pushes and never pulls, however fast the point leaves
    const double force = std::max(0.0, gains_.stiffness * depth + gains_.damping * approach);
    const double damping = force > 0 ? gains_.damping : 0.0;
    Vec6 along_shell;  // the generalized direction of a unit force on the point
    along_shell << r_shell.cross(n), n;
    Vec6 along_map;
    along_map << r_map.cross(n), n;
    shell_V.force += force * along_shell;
    shell_V.stiffness += gains_.stiffness * along_shell * along_shell.transpose();
    shell_V.damping += damping * along_shell * along_shell.transpose();
    map_V.force -= force * along_map;
    map_V.stiffness += gains_.stiffness * along_map * along_map.transpose();
    map_V.damping += damping * along_map * along_map.transpose();
  }
  if (report.loaded_points == 0) return;
  const Mat3 R_WV = X_WV.q.toRotationMatrix();
  on_shell += Turned(shell_V, R_WV);
  on_map += Turned(map_V, R_WV);
}

PairReport ContactPair::Collide(const BodyMotion& shell_body, const BodyMotion& map_body,
                                Load& on_shell, Load& on_map) noexcept {
  PairReport report;
  const Pose X_WV = map_body.X_WB * X_BV_;
  const Pose X_VS = X_WV.Inverse() * shell_body.X_WB;
  if (!MayMeet(X_VS)) return report;
  FindPoints(X_VS, 2 + force_layer_);
  AddForces(X_VS, shell_body, map_body, X_WV, report, on_shell, on_map);
  return report;
}

PoseReading ContactPair::Read(const BodyMotion& shell_body, const BodyMotion& map_body) noexcept {
  PoseReading reading;
  const Pose X_WV = map_body.X_WB * X_BV_;
  const Pose X_VS = X_WV.Inverse() * shell_body.X_WB;
  if (!MayMeet(X_VS)) return reading;
  FindPoints(X_VS, voxmap_->beyond() - 1);
  for (std::size_t i = 0; i < found_count_; ++i) {
    reading.nearest_voxels = std::min(reading.nearest_voxels, std::max(0, found_[i].value - 2));
    reading.touching_points += found_[i].value <= 2 + force_layer_ ? 1 : 0;
  }
  PairReport report;
  Load on_map;
  AddForces(X_VS, shell_body, map_body, X_WV, report, reading.on_shell, on_map);
  reading.contact_points = report.contact_points;
  return reading;
}

}  // namespace tandem
