#pragma once

#include <cstddef>
#include <vector>

#include "engine/geometry/mesh_tree.h"
#include "engine/geometry/winding_number.h"

namespace tandem {

/// What exact geometry says of a push.
struct JudgedPush {
  double distance_voxels = 0;  // of the two surfaces at the push's place, either side
  double askew_deg = 0;        // of the push from the way in which the surfaces are apart there
};

/// How many pushes exact geometry does not confirm.
struct FalsePushes {
  std::size_t contacts = 0;  // that were judged
  std::size_t farther = 0;   // where the other surface is farther than 0.6 voxel
  std::size_t askew = 0;     // by more than 10 degrees
  double force = 0;          // N, of all that were judged, added up
  double false_force = 0;    // N, of those that are false in either way

  /// `force` in N.
  void Count(const JudgedPush& push, double force);
  double force_share() const { return force > 0 ? false_force / force : 0.0; }
  FalsePushes& operator+=(const FalsePushes& other);
};

/// Judges how two bodies push each other by their triangles alone, without voxels and fields. A
/// push acts at a place on one of the surfaces, or between two edges that cross. The right way is
/// that from the nearest point of the other surface, out of its solid. Where several faces, edges
/// and corners are as near to 0.02 voxel, their ways and all that lies between them are right.
class PushJudge {
 public:
  /// The map's mesh stands in W; the shell's is in its body's frame B. `voxel_size` in metres.
  PushJudge(const TriangleMesh& map_W, const TriangleMesh& shell_B, double voxel_size);

  /// `nhat_W`: the unit way in which the shell's body, which stands at X_WB, is pushed at p_W.
  JudgedPush Judge(const Vec3& p_W, const Vec3& nhat_W, const Pose& X_WB) const;

 private:
  struct Surface {
    explicit Surface(const TriangleMesh& mesh);
    /// The ways off it at a place, each of unit length, with the distance, m.
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

/// The angle between a unit vector and the cone that unit vectors span, degrees.
double AngleFromCone(const Vec3& unit, const std::vector<Vec3>& spanning);

}  // namespace tandem
