#pragma once

#include "engine/base/spatial.h"

namespace tandem {

/// The distance between exact features at which the refined model's force begins, voxels.
inline constexpr double kRefinedClearance = 0.45;

/// The least cosine between the directions in which two features push. Below it they are on far
/// sides of thin walls, or of parts that stand on one another.
inline constexpr double kFacing = 0.2;
/// The same for edges that cross, whose arcs are known. Square edges of two faces that lie on one
/// another, turned by 45 degrees, have 0.15. The arcs decide above this bound, down to where the
/// pushes of square edges have faded out.
inline constexpr double kFacingAcross = -0.3;

/// Sine of the angle between two edges below which they count as parallel.
inline constexpr double kParallel = 0.15;
/// Voxels that a piece of an edge, whose ends are known to a hundredth, reaches into the next. Both
/// share what lies there.
inline constexpr double kSeam = 0.05;
/// Least sum of the two edges' normals along the direction in which they push each other; contacts
/// have 0.3.
inline constexpr double kSides = 0.2;

/// The arc about an edge's own normal in which the normals of its faces lie, and how a push beside
/// it fades out.
struct EdgeArc {
  double cosine = 1;  // cosine of half the arc
  double sine = 0;
  double last = 0;     // cosine at which a push has faded out
  double scale = 0;    // 1 / (cosine - last)
  bool loose = false;  // only the edge's own normal is known, not those of its faces

  explicit EdgeArc(double half_angle = 0);
  /// Makes the arc from the cosine of its half, without trigonometric functions.
  static EdgeArc FromCosine(double cosine);
  /// Returns the share of a push that counts, from the cosine between the push and the edge's
  /// normal.
  double ShareOf(double push_cosine) const noexcept;
};

/// Returns the arc within which a push on an edge by a vertex or an open rim counts.
const EdgeArc& LooseArc() noexcept;
/// An edge point of the shell: its piece of the edge, in voxels of V.
struct ShellEdge {
  Vec3 p;
  Vec3 tangent;
  Vec3 nhat;  // inward normal: the direction in which it is pushed
  double half;
  EdgeArc arc;
  bool ends = false;  // the piece ends at a vertex, which the tangent points away from
  double fade = 0.5;  // half a voxel of the shell, over which a push fades out towards that vertex
};

/// The push between two pieces of edges.
struct EdgeEdgeContact {
  double depth = 0;  // voxels
  double share = 0;  // share of the push that counts; 0: they do not push
  Vec3 normal = Vec3::Zero();
  Vec3 place = Vec3::Zero();     // voxels of V
  Vec3 on_shell = Vec3::Zero();  // place on the shell's edge, voxels of V

  double counted_depth() const { return depth * share; }
};

/// A piece of the other body's edge, voxels.
struct OtherEdge {
  Vec3 q;
  Vec3 tangent;
  Vec3 nhat;  // outward normal, on the side that the shell's edge faces
  double half;
  EdgeArc arc;
  bool ends = false;
};

/// Finds how the two pieces push each other from `reach` on.
EdgeEdgeContact FindEdgeContact(const ShellEdge& edge, const OtherEdge& other,
                                double reach) noexcept;

}  // namespace tandem
