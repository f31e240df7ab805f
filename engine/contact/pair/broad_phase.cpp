#include "engine/contact/pair/broad_phase.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace tandem {

namespace {

/// Returns the distance from a box about the origin to something that lies `outside` beyond each of
/// its faces.
double FromBox(const Vec3& outside) {
  const double nearest = outside.maxCoeff();
  return nearest > 0 ? outside.cwiseMax(Vec3::Zero()).norm() : nearest;
}

/// Returns the gap along the nine cross products of an edge of each box. `t`: from a's centre to
/// b's, in a's axes.
double BetweenEdges(const Vec3& a, const Vec3& b, const Mat3& R, const Vec3& t) {
  constexpr double kParallel = 1e-9;  // squared sine; below it a face's axis gives the same gap
  double gap = -a.norm() - b.norm();
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Eigen::Index i1 = (i + 1) % 3;
    const Eigen::Index i2 = (i + 2) % 3;
    for (Eigen::Index j = 0; j < 3; ++j) {
      const double square = 1.0 - R(i, j) * R(i, j);
      if (square < kParallel) continue;
      const Eigen::Index j1 = (j + 1) % 3;
      const Eigen::Index j2 = (j + 2) % 3;
      const double between = std::abs(t[i2] * R(i1, j) - t[i1] * R(i2, j));
      const double of_a = a[i1] * std::abs(R(i2, j)) + a[i2] * std::abs(R(i1, j));
      const double of_b = b[j1] * std::abs(R(i, j2)) + b[j2] * std::abs(R(i, j1));
      gap = std::max(gap, (between - of_a - of_b) / std::sqrt(square));
    }
  }
  return gap;
}

}  // namespace

Extent ExtentOf(const Pointshell& points) {
  Extent extent;
  if (points.size() == 0) return extent;
  Vec3 low = points.point(0);
  Vec3 high = low;
  for (std::size_t i = 1; i < points.size(); ++i) {
    low = low.cwiseMin(points.point(i));
    high = high.cwiseMax(points.point(i));
  }
  extent.centre = 0.5 * (low + high);
  extent.half_size = 0.5 * (high - low);
  for (std::size_t i = 0; i < points.size(); ++i) {
    extent.radius = std::max(extent.radius, (points.point(i) - extent.centre).norm());
  }
  return extent;
}

Extent ExtentOf(const Voxmap& voxmap) {
  constexpr int kChunks = kHyperchunkSide / kChunkSide;
  const auto& size = voxmap.header().size;
  Eigen::Array3i low = Eigen::Array3i::Constant(INT32_MAX);
  Eigen::Array3i high = Eigen::Array3i::Constant(INT32_MIN);
  const std::uint32_t* record = voxmap.index();
  for (std::uint32_t z = 0; z < size[2]; ++z) {
    for (std::uint32_t y = 0; y < size[1]; ++y) {
      for (std::uint32_t x = 0; x < size[0]; ++x, ++record) {
        const VoxmapRecord& held = voxmap.records()[*record];
        for (std::size_t cell = 0; cell < kChunksPerHyperchunk; ++cell) {
          if ((held.chunk_marks[cell >> 1] >> ((cell & 1) * 4) & 15) != kSurfaceMark) continue;
          const GridIndex c = BlockCell(cell);
          const Eigen::Array3i chunk(static_cast<int>(x) * kChunks + c.x,
                                     static_cast<int>(y) * kChunks + c.y,
                                     static_cast<int>(z) * kChunks + c.z);
          low = low.min(chunk);
          high = high.max(chunk + 1);
        }
      }
    }
  }
  Extent extent;
  if ((low >= high).any()) return extent;
  const double chunk_size = kChunkSide * voxmap.voxel_size();
  extent.centre = 0.5 * chunk_size * (low + high).cast<double>().matrix();
  extent.half_size = 0.5 * chunk_size * (high - low).cast<double>().matrix();
  extent.radius = extent.half_size.norm();
  return extent;
}

double GapBetween(const Extent& a, const Extent& b, const Pose& X_AB, double enough) noexcept {
  const Mat3 R = X_AB.q.toRotationMatrix();
  const Vec3 t = X_AB.p + R * b.centre - a.centre;
  const Vec3 u = R.transpose() * t;  // in b's axes
  const Vec3 beyond_a = t.cwiseAbs() - a.half_size;
  const Vec3 beyond_b = u.cwiseAbs() - b.half_size;
  double gap = std::max(FromBox(beyond_a) - b.radius, FromBox(beyond_b) - a.radius);
  if (gap >= enough) return gap;
  const Mat3 part = R.cwiseAbs();
  gap = std::max(gap, FromBox(beyond_a - part * b.half_size));
  gap = std::max(gap, FromBox(beyond_b - part.transpose() * a.half_size));
  return std::max(gap, BetweenEdges(a.half_size, b.half_size, R, t));
}

}  // namespace tandem
