#pragma once

#include "engine/base/spatial.h"
#include "engine/voxel/map/voxmap.h"
#include "engine/voxel/points/pointshell.h"

namespace tandem {

/// A box and a ball that each hold all points of a body, or all marks of a map, in its frame.
struct Extent {
  Vec3 centre = Vec3::Zero();     // centre of both, m
  Vec3 half_size = Vec3::Zero();  // half size of the box, m
  double radius = 0;              // radius of the ball, m
};

/// Returns the extent of the points as they stand in B, not displaced.
Extent ExtentOf(const Pointshell& points);
/// Returns the extent of the chunks of V that hold a mark. Outside it every field reads beyond.
Extent ExtentOf(const Voxmap& voxmap);

/// Returns a lower bound of the distance between what is in `a` and what is in `b`, m; negative
/// where nothing is certain. It is the greatest of several distances, each between two convex sets
/// that hold one body each, so it never exceeds the distance of the bodies:
///
///   the box of one and the ball of the other, both ways
///   the box of one and the other's bounds along its axes, both ways
///   the shadows of the two boxes on the cross product of an edge of each (nine)
///
/// By the theorem of separating axes it is above zero whenever the two boxes are apart (decision
/// 0011). If the balls alone are `enough` apart, the boxes are not looked at.
double GapBetween(const Extent& a, const Extent& b, const Pose& X_AB, double enough) noexcept;

}  // namespace tandem
