#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "engine/base/spatial.h"

namespace tandem {

/// The places round one where a point of the shell was looked at, at which it makes no contact
/// however it got there: within `reach` of it, on the near side of a cone about a plane, which
/// comes nearer as the bodies turn against one another, and until they have turned too far. A part
/// of those places, so what is known clear is clear (docs/decisions/0025-refined-coherence.md).
///
/// Lengths in voxels of V. A cache line.
struct ClearRegion {
  static constexpr std::uint32_t kNoPoint = std::numeric_limits<std::uint32_t>::max();

  Vec3 from = Vec3::Zero();
  double turned = 0;  // rad, by whoever counts turns
  Vec3f normal = Vec3f::Zero();
  float margin = 0;                // how far the point may go against the normal
  float spread = 0;                // how much less for each voxel that it goes
  float swing = 0;                 // and for each rad that the bodies turn
  float reach = 0;                 // 0: nothing is known
  std::uint32_t point = kNoPoint;  // of the shell

  /// When the bodies have turned by `now`, and for no longer than they turn by `turn`.
  bool Holds(const Vec3& p, double now, double turn) const noexcept {
    const Vec3 way = p - from;
    const double square = way.squaredNorm();
    const double by = now - turned;
    const double left = margin + way.dot(normal.cast<double>()) - swing * by;
    return by < turn && square < static_cast<double>(reach) * reach && left > 0 &&
           left * left > static_cast<double>(spread) * spread * square;
  }
  /// Whether all is known by how far the point goes.
  bool round() const noexcept { return normal.isZero(); }
  /// How far a point at `p`, where the region holds, may go in any direction, while the bodies turn
  /// by up to `turns` rad for each voxel.
  double Room(const Vec3& p, double now, double turn, double turns) const noexcept;
};
static_assert(sizeof(ClearRegion) == 64);

/// Finds a region from all that can push a point.
class ClearRegionMaker {
 public:
  /// Voxels: no region reaches farther, so the windows of pieces within two voxels do.
  static constexpr double kReach = 0.5;

  /// `turn`: rad that the bodies may turn.
  void Begin(double turn) noexcept {
    turn_ = turn;
    reach_ = kReach;
    count_ = 0;
  }
  /// For who wants none: empty from the first.
  void BeginNone() noexcept {
    turn_ = 0;
    reach_ = 0;
    count_ = 0;
  }
  double turn() const noexcept { return turn_; }
  /// Nothing can come of it any more.
  bool empty() const noexcept { return reach_ <= kLeast; }
  double reach() const noexcept { return reach_; }
  /// What pushes only after the point has gone by `way`.
  void KeepWithin(double way) noexcept {
    if (way < reach_) reach_ = way;
  }
  /// What does not push before the point has gone by `margin` against `normal`, less `swing` for
  /// each rad that the bodies turn, nor before it has gone by `way` in any direction.
  void KeepAbove(const Vec3& normal, double margin, double swing, double way) noexcept;
  /// Of a point at `p` when the bodies have turned by `turned`; not if empty.
  ClearRegion Make(const Vec3& p, double turned, std::uint32_t point) const noexcept;

 private:
  /// Voxels: less is not worth being kept, and more than all rounding.
  static constexpr double kLeast = 1e-3;
  struct Half {
    Vec3 normal;
    double margin;
    double swing;
  };

  double turn_ = 0;
  double reach_ = 0;
  std::size_t count_ = 0;
  std::array<Half, 64> halves_;
};

}  // namespace tandem
