#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "engine/geometry/exact/mesh_tree.h"
#include "engine/geometry/exact/tree_pair.h"
#include "engine/geometry/exact/winding_number.h"
#include "engine/proximity/surface_tree.h"
#include "engine/voxel/map/voxmap.h"

/// Other uses of the distance field (paper §3.1): colours by distance, the voxels near a body, the
/// least distance of two bodies, the distance's gradient. They run beside the haptic loop and never
/// in it. They only read shared data, so any number of threads may use them.
///
/// Bodies stand in frames A and B: W at the time of their voxelization. For a body displaced since
/// then by X_W, against another displaced by Y_W: X_BA = Y_W^-1 X_W.
namespace tandem {

/// A body or fixture for proximity queries. Read-only once built.
struct ProximityShape {
  ProximityShape() = default;
  ProximityShape(const TriangleMesh& mesh_W, Voxmap map);

  Voxmap voxmap;
  SurfaceTree surface;
  MeshTree mesh;
  std::optional<WindingNumber> winding;
};

/// Lowers each element of `distances` to the distance (m) of its point from the surface, where that
/// is less. The distance is interpolated in the surface field between the centres of voxels. It is
/// a chess-board distance: at most 1.1 voxels above the true distance, and at least 1/sqrt(3) of it
/// less a voxel. It is 0 inside. Elements beyond the field's range stay.
void LowerDistances(std::span<const std::array<float, 3>> points_A, const Pose& X_BA,
                    const Voxmap& map_B, std::span<float> distances) noexcept;

/// Returns the colour of a distance, warm where near: red at 0, orange at a quarter of the range,
/// yellow at half, pale blue at three quarters, blue at the whole range and beyond.
std::array<float, 3> ProximityColour(double distance, double range) noexcept;

/// Returns the unit direction in which the distance from the shape's surface grows fastest (inside:
/// the depth shrinks), by voxels alone; zero beyond the field's range. It is the mean of the
/// directions from the voxels that are nearly the nearest. Within 1.5 voxels it follows from the
/// side of the surface that the voxels round p are on. It errs most beside edges: its errors are in
/// docs/results/0012-proximity.csv.
Vec3 VoxelGradient(const ProximityShape& shape, const Vec3& p_B) noexcept;

/// The nearness of two bodies. Their exact distance, 0 where they overlap, lies in [least, most].
struct Nearness {
  double distance = std::numeric_limits<double>::infinity();  // m, the best estimate
  double least = 0;
  double most = std::numeric_limits<double>::infinity();
  Vec3 p_BA = Vec3::Zero();  // the point on A, in B
  Vec3 p_BB = Vec3::Zero();  // the point on B
  /// The unit direction in B in which moving A gains distance fastest. It follows the two points
  /// when they are refined or farther apart than the fields reach; otherwise it is VoxelGradient().
  /// Zero when it is not known.
  Vec3 gradient_B = Vec3::Zero();
  bool overlap = false;  // a surface crosses the other, or a voxel of A lies inside B
  bool refined = false;  // the points lie on the exact triangles
  /// m, where they overlap: the depth of the deepest place found of one surface in the other. 0:
  /// none was found, or it was not asked for.
  double depth = 0;

  double error_bound() const { return std::max(most - distance, distance - least); }
};

/// Options of the search for the nearest points: whether it goes on from voxels to triangles, and
/// how far.
struct NearestOptions {
  bool refine = true;
  std::size_t most_pairs = 100000;  // most pairs of triangles: some milliseconds
  bool depth = false;               // look how deep they overlap: up to some tenths of a second
};

/// Returns the depth (m) of the deepest place found of either surface in the other. Places are the
/// corners of triangles and those nearest to the middles of surface voxels, about as far apart as
/// voxels. Of very many an even share is tried. So it may be less than the greatest depth.
double DepthOfOverlap(const ProximityShape& a, const ProximityShape& b, const Pose& X_BA) noexcept;

/// The number of voxels near a body.
struct ShadowCount {
  std::size_t found = 0;    // all voxels found
  std::size_t written = 0;  // voxels written, up to the room given
  bool capped() const { return written < found; }
};

/// Compares one body with another. The shapes must outlive it. Used by one thread, because it has a
/// workspace. No call allocates.
class ProximityPair {
 public:
  ProximityPair(const ProximityShape& a, const ProximityShape& b);

  /// Finds the least distance of the two, at any separation. It first compares surface voxels.
  /// Their centres are within sqrt(3)/2 voxels of the surface, so the error is at most half sqrt(3)
  /// times the sum of the two voxel sizes. Then it compares the triangles that this leaves in
  /// question. Their bound is never worse, and a thousandth of a voxel when the search is complete.
  /// It detects overlap where A's surface enters B, but not when B lies wholly inside A.
  Nearness Nearest(const Pose& X_BA, const NearestOptions& options = {}) noexcept;

  /// Finds the centres of B's surface voxels within `distance` of the centre of a surface voxel of
  /// A (m, in B): A's shadow on B.
  ShadowCount Shadow(const Pose& X_BA, double distance, std::span<Vec3> centres_B) noexcept;

 private:
  struct VoxelPair {
    double distance = std::numeric_limits<double>::infinity();
    Vec3 p_BA = Vec3::Zero();
    Vec3 p_BB = Vec3::Zero();
  };

  Vec3 MiddleOf(std::uint32_t chunk) const noexcept;  // in A
  /// Takes a chunk of A's points to B, as offsets from the chunk's middle.
  void Load(std::uint32_t chunk, const RotatedFrame& X_BA) noexcept;
  /// Returns the squared distance from an offset to the nearest loaded point.
  float LeastSquared(const Eigen::Vector3f& offset) const noexcept;
  VoxelPair NearestVoxels(const RotatedFrame& X_BA) noexcept;
  /// Tells whether A's surface enters B, given that it is farther than `apart` (m) from B's.
  bool Enters(const Pose& X_BA, double apart) noexcept;
  /// Calls visit(centre in B) for A's surface voxels whose centres are in voxels inside B, until it
  /// returns true. Returns whether it did.
  template <class Visit>
  bool AnyInside(const RotatedFrame& X_BA, const Visit& visit) noexcept;

  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  const ProximityShape* a_;
  const ProximityShape* b_;

  std::uint32_t loaded_ = kNone;  // chunk of A
  std::size_t count_ = 0;         // its points, filled up to a multiple of 8
  Vec3 middle_B_ = Vec3::Zero();
  double radius_ = 0;  // radius of all points round the middle, m
  alignas(64) std::array<float, kVoxelsPerChunk> x_{};
  alignas(64) std::array<float, kVoxelsPerChunk> y_{};
  alignas(64) std::array<float, kVoxelsPerChunk> z_{};

  std::vector<std::array<std::uint64_t, 8>> in_shadow_;  // per chunk of B
  std::vector<std::uint32_t> shaded_;                    // chunks of B with a voxel in the shadow
};

}  // namespace tandem
