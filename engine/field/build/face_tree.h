#pragma once

#include <array>
#include <limits>
#include <vector>

#include "engine/field/build/face_distance.h"
#include "engine/field/query/field_brick.h"
#include "engine/geometry/exact/box_tree.h"
#include "engine/voxel/map/voxel.h"

namespace tandem {

/// Finds the nearest of many faces.
class FaceTree {
 public:
  /// The faces must outlive it.
  explicit FaceTree(const std::vector<FieldFace>& faces);

  /// Returns the distance of the nearest face that is nearer than `below`, otherwise `below`,
  /// voxels. Where some face is nearer, the bits do not depend on `below`.
  double Nearest(const Vec3& place_L, double below = std::numeric_limits<double>::infinity()) const;

 private:
  const std::vector<FieldFace>& faces_;
  BoxTree tree_;
};

/// The distances of a hyperbrick's nodes, each measured when it is first needed.
class FarNodes {
 public:
  /// `first` is the hyperbrick's lowest node.
  FarNodes(const FaceTree& faces, const GridIndex& first) : faces_(faces), first_(first) {}

  /// Returns the distance of a node. `node` is relative to the hyperbrick's lowest, 0 to
  /// kHyperbrickCells.
  float DistanceOf(const GridIndex& node);
  /// Returns the distances of a brick's nodes, as NodeInBrick. `brick` is its place in the
  /// hyperbrick, as CellInBlock.
  std::array<float, kBrickNodes> InBrick(std::size_t brick);
  /// Measures the nodes of a brick whose values are a survey's reach or more; for these the survey
  /// has only the distance of the nearest plane. Returns whether another face is nearer to a node.
  bool MeasureBeyond(std::size_t brick, std::array<float, kBrickNodes>& values);

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
