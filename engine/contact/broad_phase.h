#pragma once

#include "engine/base/spatial.h"
#include "engine/voxel/pointshell.h"
#include "engine/voxel/voxmap.h"

namespace tandem {

/// A box and a ball that each hold all of a body's points, or of a map's marks, in its frame.
struct Extent {
  Vec3 centre = Vec3::Zero();     // of both, m
  Vec3 half_size = Vec3::Zero();  // of the box, m
  double radius = 0;              // of the ball, m
};

/// Of the points as they stand in B, not displaced.
Extent ExtentOf(const Pointshell& points);
/// Of the chunks of V that hold a mark: outside, every field reads beyond.
Extent ExtentOf(const Voxmap& voxmap);

/// A lower bound of the distance between what is in `a` and what is in `b`, m; negative where
/// nothing is certain. Each number that it is the greatest of is a distance between two convex sets
/// that hold one body each, so it is never more than that of the bodies themselves:
///
///   the box of one and the ball of the other, both ways
///   the box of one and the other's bounds along its axes, both ways
///   the shadows of the two boxes on the cross product of an edge of each (nine)
///
/// By the theorem of separating axes it is above zero whenever the two boxes are apart (decision
/// 0011). What is found to be `enough` apart by the balls alone is not looked at further.
double GapBetween(const Extent& a, const Extent& b, const Pose& X_AB, double enough) noexcept;

}  // namespace tandem
