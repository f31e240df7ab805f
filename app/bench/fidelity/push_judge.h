#pragma once

#include <cstddef>
#include <vector>

#include "engine/geometry/exact/mesh_tree.h"
#include "engine/geometry/exact/winding_number.h"

namespace tandem {

/// The judgement of exact geometry on a push.
struct JudgedPush {
  double distance_voxels = 0;  // sum of the distances of both surfaces from the push's place
  /// Angle of the push from the direction in which the surfaces are apart there.
  double askew_deg = 0;
};

/// Counts the pushes that exact geometry does not confirm.
struct FalsePushes {
  std::size_t contacts = 0;  // number of judged contacts
  std::size_t farther = 0;   // pushes where the other surface is farther than 0.6 voxel
  std::size_t askew = 0;     // pushes askew by more than 10 degrees
  double force = 0;          // N, sum over all judged contacts
  double false_force = 0;    // N, sum over those that are false in either way

  /// Counts a push. `force` in N.
  void Count(const JudgedPush& push, double force);
  double force_share() const { return force > 0 ? false_force / force : 0.0; }
  FalsePushes& operator+=(const FalsePushes& other);
};

/// Judges how two bodies push each other by their triangles alone, without voxels and fields. A
/// push acts at a place on one of the surfaces, or between two edges that cross. The right
/// direction is from the nearest point of the other surface, out of its solid. Where several faces,
/// edges and corners are equally near to 0.02 voxel, their directions and all between them are
/// right.
class PushJudge {
 public:
  /// The map's mesh stands in W; the shell's is in its body's frame B. `voxel_size` in metres.
  PushJudge(const TriangleMesh& map_W, const TriangleMesh& shell_B, double voxel_size);

  /// Judges a push at p_W. `nhat_W`: unit direction in which the shell's body, which stands at
  /// X_WB, is pushed.
  JudgedPush Judge(const Vec3& p_W, const Vec3& nhat_W, const Pose& X_WB) const;

 private:
  struct Surface {
    explicit Surface(const TriangleMesh& mesh);
    /// The unit directions off the surface at a place, and its distance, m.
    struct Ways {
      double distance;
      std::vector<Vec3> off;
    };
    Ways At(const Vec3& p, double tie, double touching) const;

    MeshTree mesh;
    WindingNumber winding;
  };

  double s_;  // voxel size, m
  Surface map_;
  Surface shell_;
};

/// Returns the angle between a unit vector and the cone that unit vectors span, degrees.
double AngleFromCone(const Vec3& unit, const std::vector<Vec3>& spanning);

}  // namespace tandem
