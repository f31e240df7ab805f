#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "app/judgement/sample_tree.h"
#include "engine/base/spatial.h"
#include "engine/geometry/exact/exact_surface.h"
#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// The findings of the oracle over a run.
struct PenetrationReport {
  double max_penetration_voxels = 0;  // 0 if never inside
  // voxels by which the moving body may be deeper at that pose; set by Refine()
  double error_voxels = 0.5;
  std::size_t overlapping_poses = 0;  // poses with at least one sample inside
  std::size_t poses_checked = 0;
  std::size_t poses_given = 0;
  // deepest place; meaningless if never inside
  std::size_t worst_series = 0;
  std::size_t worst_pose = 0;    // index in that series
  Vec3 p_FWorst = Vec3::Zero();  // m

  /// Returns the share of overlapping poses among those checked.
  double overlap_share() const {
    return poses_checked == 0
               ? 0.0
               : static_cast<double>(overlapping_poses) / static_cast<double>(poses_checked);
  }
};

/// Returns both reports as one, for two pairs of bodies in one run. The worst place is that of the
/// deeper one. The series of `second` are counted on behind those of `first` (which had
/// `series_of_first`).
PenetrationReport Merged(const PenetrationReport& first, const PenetrationReport& second,
                         std::size_t series_of_first);

/// Returns a voxel size, at least the given one, by which an oracle takes at most `most_samples`
/// samples of the mesh. Samples at vertices and along edges come in addition.
double SampledVoxel(const TriangleMesh& mesh, double voxel_size, double most_samples = 1e6);

/// Judges after a run whether a moving body was ever in a fixture, and how deep, by exact geometry
/// and not by the voxmap. It tests samples of the moving mesh, half a voxel apart (SampleSurface),
/// against the union of the fixture's bodies (ExactSurface).
///
/// The fixture may move too (ball and socket). F is its body frame, and the poses are relative:
/// X_FB = X_WF.Inverse() * X_WB. For a fixed one put its meshes into W first; then F is W. Several
/// fixed meshes go in as one, by Append().
///
///   PenetrationOracle oracle(fixture_W, part_B, voxel_size);
///   const PenetrationReport report = oracle.Check(poses_of_each_instance, 2, out_of_time);
class PenetrationOracle {
 public:
  /// Builds the trees on all cores, which takes seconds for large meshes.
  PenetrationOracle(const TriangleMesh& fixture_F, const TriangleMesh& moving_B, double voxel_size);

  /// Checks all poses X_FB. Each series is in the order of time: poses that follow one another are
  /// near one another, which makes it fast. Several threads ask `out_of_time` before every pose.
  /// Once it is true, the rest is left out. Work goes in blocks of kBlock poses in bit-reversed
  /// order, so the poses checked by then are spread evenly over all series. The number of threads
  /// changes no figure when time suffices.
  PenetrationReport Check(std::span<const std::vector<Pose>> series, int threads,
                          const std::function<bool()>& out_of_time) const;

  /// Replaces the depth of the deepest sample by the greatest depth of the moving mesh at that
  /// pose, and bounds its error. `report`: of Check() over the same poses.
  void Refine(std::span<const std::vector<Pose>> series, PenetrationReport& report) const;

  /// Returns the depth of the deepest sample at a pose, voxels; 0 if none is inside.
  double PenetrationVoxels(const Pose& X_FB) const;

  std::size_t samples() const { return samples_.points(); }
  const ExactSurface& fixture() const { return fixture_; }

  static constexpr std::size_t kBlock = 64;

 private:
  class Search;

  double voxel_size_;
  ExactSurface fixture_;
  TriangleMesh moving_B_;
  SampleTree samples_;
};

}  // namespace tandem
