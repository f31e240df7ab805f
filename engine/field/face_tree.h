#pragma once

#include <limits>
#include <vector>

#include "engine/field/face_distance.h"
#include "engine/geometry/box_tree.h"

namespace tandem {

/// Finds the nearest of many faces.
class FaceTree {
 public:
  /// The faces must outlive it.
  explicit FaceTree(const std::vector<FieldFace>& faces);

  /// The distance of the nearest face that is nearer than `below`; otherwise
  /// `below`. Voxels. The same bits whatever `below` is, where some face is
  /// nearer.
  double Nearest(const Vec3& place_L, double below = std::numeric_limits<double>::infinity()) const;

 private:
  const std::vector<FieldFace>& faces_;
  BoxTree tree_;
};

/// The distances of a hyperbrick's nodes, each measured when it is asked for
/// first.
class FarNodes {
 public:
  /// `first` is the hyperbrick's lowest node.
  FarNodes(const FaceTree& faces, const GridIndex& first) : faces_(faces), first_(first) {}

  /// `node` is counted from the hyperbrick's lowest, 0 to kHyperbrickCells.
  float DistanceOf(const GridIndex& node);

 private:
  static constexpr std::int32_t kSide = kHyperbrickCells + 1;
  static constexpr float kNotMeasured = -1;

  const FaceTree& faces_;
  GridIndex first_;
  std::vector<float> distances_;
  GridIndex last_;
  double distance_of_last_ = std::numeric_limits<double>::infinity();
};

}  // namespace tandem
