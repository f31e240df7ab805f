#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "engine/geometry/mesh_tree.h"
#include "engine/geometry/tree_pair.h"
#include "engine/geometry/winding_number.h"
#include "engine/voxel/voxmap.h"
#include "engine/world/surface_tree.h"

/// Other uses of the distance field (paper §3.1): colours by distance, the voxels near a body, the
/// least distance of two bodies, the distance's gradient. Beside the haptic loop and never in it;
/// whatever is shared is only read, so any number of threads may ask.
///
/// Bodies stand in frames A and B: W as it stood when they were voxelized. A body that has been
/// displaced by X_W since then, against another displaced by Y_W: X_BA = Y_W^-1 X_W.
namespace tandem {

/// A body or fixture, as others come near to it. Read-only once built.
struct ProximityShape {
  ProximityShape() = default;
  ProximityShape(const TriangleMesh& mesh_W, Voxmap map);

  Voxmap voxmap;
  SurfaceTree surface;
  MeshTree mesh;
  std::optional<WindingNumber> winding;
};

/// The distance (m) of each point from the surface, read from the surface field between the centres
/// of voxels and written where it is less than what is there. It counts as the chess-board does: at
/// most 1.1 voxels more than the true distance, and no less than 1/sqrt(3) of it less a voxel. 0
/// inside; untouched beyond the field's range.
void LowerDistances(std::span<const std::array<float, 3>> points_A, const Pose& X_BA,
                    const Voxmap& map_B, std::span<float> distances) noexcept;

/// The colour of a distance, warm where near: red at 0, orange at a quarter of the range, yellow at
/// half, pale blue at three quarters, blue at the whole range and everywhere beyond.
std::array<float, 3> ProximityColour(double distance, double range) noexcept;

/// The unit direction in which the distance from the shape's surface grows fastest (inside: the
/// depth shrinks), by voxels alone: the mean of the directions from those that are nearly the
/// nearest, and within 1.5 voxels by which side of the surface the voxels round p are on; zero
/// beyond the field's range. Off a sphere of 25
/// voxels it is out by at most 15 degrees, off a turned box by 50 at its edges; 7.5 in the mean,
/// and half of that from 2 voxels on: docs/decisions/0012-proximity.md.
Vec3 VoxelGradient(const ProximityShape& shape, const Vec3& p_B) noexcept;

/// How near two bodies are. Their exact distance, 0 where they overlap, lies in [least, most].
struct Nearness {
  double distance = std::numeric_limits<double>::infinity();  // m, the best estimate
  double least = 0;
  double most = std::numeric_limits<double>::infinity();
  Vec3 p_BA = Vec3::Zero();  // the point on A, in B
  Vec3 p_BB = Vec3::Zero();  // the point on B
  /// The unit direction in B in which moving A gains distance fastest: along the two points when
  /// they are refined or farther apart than the fields reach, else VoxelGradient(); zero when none
  /// can be told.
  Vec3 gradient_B = Vec3::Zero();
  bool overlap = false;  // a surface crosses the other, or a voxel of A's lies inside B
  bool refined = false;  // by the exact triangles: the points lie on them

  double error_bound() const { return std::max(most - distance, distance - least); }
};

/// Whether the search goes on from voxels to triangles, and how far.
struct NearestOptions {
  bool refine = true;
  std::size_t most_pairs = 100000;  // of triangles: some milliseconds
};

/// The voxels near a body.
struct ShadowCount {
  std::size_t found = 0;    // in all
  std::size_t written = 0;  // as many as there was room for
  bool capped() const { return written < found; }
};

/// One body against another. The shapes must outlive it; used by one thread, for it keeps room to
/// work in. No call allocates.
class ProximityPair {
 public:
  ProximityPair(const ProximityShape& a, const ProximityShape& b);

  /// The least distance of the two, at any separation. By surface voxels first, whose centres are
  /// within sqrt(3)/2 voxels of the surface, so the error is at most half sqrt(3) times the sum of
  /// the two voxel sizes; then by the triangles that this leaves in question, whose bound is never
  /// worse and, when the search came to its end, a thousandth of a voxel.
  /// Overlap is seen where A's surface enters B; that B lies wholly inside A is not.
  Nearness Nearest(const Pose& X_BA, const NearestOptions& options = {}) noexcept;

  /// The centres of B's surface voxels within `distance` of the centre of one of A's (m, in B): A's
  /// shadow on B.
  ShadowCount Shadow(const Pose& X_BA, double distance, std::span<Vec3> centres_B) noexcept;

 private:
  struct VoxelPair {
    double distance = std::numeric_limits<double>::infinity();
    Vec3 p_BA = Vec3::Zero();
    Vec3 p_BB = Vec3::Zero();
  };

  Vec3 MiddleOf(std::uint32_t chunk) const noexcept;  // in A
  /// Takes a chunk of A's points to B, as offsets from the chunk's middle.
  void Load(std::uint32_t chunk, const TurnedFrame& X_BA) noexcept;
  /// Square of the distance from an offset to the nearest loaded point.
  float LeastSquared(const Eigen::Vector3f& offset) const noexcept;
  VoxelPair NearestVoxels(const TurnedFrame& X_BA) noexcept;
  /// Tells whether A's surface enters B, given that it is farther than `apart` (m) from B's.
  bool Enters(const Pose& X_BA, double apart) noexcept;
  /// Calls visit(centre in B), until it is true, of A's surface voxels whose centres are in voxels
  /// inside B; tells whether it was.
  template <class Visit>
  bool AnyInside(const TurnedFrame& X_BA, const Visit& visit) noexcept;

  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  const ProximityShape* a_;
  const ProximityShape* b_;

  std::uint32_t loaded_ = kNone;  // chunk of A
  std::size_t count_ = 0;         // of its points, filled up to a multiple of 8
  Vec3 middle_B_ = Vec3::Zero();
  double radius_ = 0;  // m, of all points round the middle
  alignas(64) std::array<float, kVoxelsPerChunk> x_{};
  alignas(64) std::array<float, kVoxelsPerChunk> y_{};
  alignas(64) std::array<float, kVoxelsPerChunk> z_{};

  std::vector<std::array<std::uint64_t, 8>> in_shadow_;  // per chunk of B
  std::vector<std::uint32_t> shaded_;                    // chunks of B with any
};

}  // namespace tandem
