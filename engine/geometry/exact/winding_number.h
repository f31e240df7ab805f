#pragma once

#include <cstddef>
#include <vector>

#include "engine/geometry/exact/box_tree.h"
#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// The generalized winding number of a triangle mesh: how often its surface goes round a point. In
/// a closed, outward body it is 1, where two bodies overlap 2, in a cavity 0, outside 0. Cracks and
/// holes change it only by the solid angle that they fill, and no ray can hit an unlucky edge. This
/// is its advantage over the parity of rays.
///
/// Distant clusters of triangles count as one dipole (Barill et al., "Fast winding numbers", 2018,
/// first order). The error is about 0.01, against a threshold of one half.
class WindingNumber {
 public:
  explicit WindingNumber(const TriangleMesh& mesh);

  double At(const Vec3& p) const {
    std::size_t steps = 0;
    return At(p, steps);
  }
  /// Adds to `steps` the number of triangles and clusters that it takes together.
  double At(const Vec3& p, std::size_t& steps) const;

 private:
  struct Corners {
    Vec3 a, b, c;
  };
  struct Dipole {
    Vec3 p = Vec3::Zero();     // area-weighted centre of the node's triangles
    Vec3 area = Vec3::Zero();  // sum of their area vectors, outward
    double near_squared = 0;   // within this (squared) distance the node must be opened
  };

  BoxTree tree_;
  std::vector<Dipole> dipoles_;     // one a node
  std::vector<Corners> triangles_;  // in the tree's order
};

/// Returns the solid angle of a triangle seen from p over 4 pi; positive seen from behind (Van
/// Oosterom).
double WindingOf(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p);

}  // namespace tandem
