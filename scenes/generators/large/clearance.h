#pragma once

#include <vector>

#include "engine/geometry/exact/box_tree.h"
#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// Measures the distance of a moving mesh from a fixed one, by samples of its surface. Any unit of
/// length; all in one frame, in which the moving mesh has its first pose.
class Clearance {
 public:
  /// Samples are at most `spacing` apart. Of the fixed mesh only triangles that come near `where`
  /// count.
  Clearance(const TriangleMesh& fixed, const Bounds& where, const TriangleMesh& moving,
            double spacing);

  /// Returns the least distance from a sample to a triangle with the moving mesh at X, or `cut_off`
  /// if none is nearer. Between samples the distance can be less by at most half the spacing.
  double At(const Pose& X, double cut_off) const;

 private:
  struct Cluster {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    Vec3 centre = Vec3::Zero();
    double radius = 0;
  };
  double ToFixed(const Vec3& p, double cut_off) const;

  TriangleMesh fixed_;
  BoxTree tree_;
  std::vector<Vec3> samples_;
  std::vector<Cluster> clusters_;
};

}  // namespace tandem
