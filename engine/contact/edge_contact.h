#pragma once

#include "engine/base/spatial.h"

namespace tandem {

/// The distance between exact features at which the refined model's force begins, voxels.
inline constexpr double kRefinedClearance = 0.45;

/// Cosine between the ways two features push, at least: below, they are on far sides of thin walls,
/// or of parts that stand on one another.
inline constexpr double kFacing = 0.2;
/// The same of edges that cross, whose arcs are known. Those of two faces that lie on one another,
/// turned by 45 degrees, have 0.15, of square edges; arcs say more than this, down to where square
/// edges' pushes have faded out.
inline constexpr double kFacingAcross = -0.3;

/// Sine of the angle between two edges below which they are taken as parallel.
inline constexpr double kParallel = 0.15;
/// Voxels: how far a piece of an edge, whose ends are known to a hundredth, reaches into the next.
/// They share what lies there.
inline constexpr double kSeam = 0.05;
/// Of the two edges' normals along the way they push each other, least sum: contacts have 0.3.
inline constexpr double kSides = 0.2;

/// The arc about an edge's own normal in which those of its faces lie, and how a push beside it
/// fades out.
struct EdgeArc {
  double cosine = 1;  // of half of it
  double sine = 0;
  double last = 0;     // cosine at which nothing is left of a push
  double scale = 0;    // 1 / (cosine - last)
  bool loose = false;  // only the edge's own normal is known, not those of its faces

  explicit EdgeArc(double half_angle = 0);
  /// From its cosine, without a turn through angles.
  static EdgeArc OfCosine(double cosine);
  /// How much of a push counts that has that cosine with the edge's normal.
  double ShareOf(double push_cosine) const noexcept;
};

/// Within which a push on an edge by a vertex or an open rim is believed.
const EdgeArc& LooseArc() noexcept;
/// An edge point of the shell: its piece of the edge, in voxels of V.
struct ShellEdge {
  Vec3 p;
  Vec3 tangent;
  Vec3 nhat;  // the inward normal: the way in which it is pushed
  double half;
  EdgeArc arc;
  bool ends = false;  // at a vertex, which the tangent points away from
  double fade = 0.5;  // half a voxel of the shell: a push fades out over it towards that vertex
};

/// How two pieces of edges push each other.
struct EdgeMeeting {
  double depth = 0;  // voxels
  double share = 0;  // how much of the push counts; 0: they do not push
  Vec3 normal = Vec3::Zero();
  Vec3 place = Vec3::Zero();     // voxels of V
  Vec3 on_shell = Vec3::Zero();  // where on the shell's edge

  double counted_depth() const { return depth * share; }
};

/// A piece of the other body's edge, voxels.
struct OtherEdge {
  Vec3 q;
  Vec3 tangent;
  Vec3 nhat;  // outward, on the side that the shell's edge faces
  double half;
  EdgeArc arc;
  bool ends = false;
};

/// How they push each other from `reach` on.
EdgeMeeting Meet(const ShellEdge& edge, const OtherEdge& other, double reach) noexcept;

}  // namespace tandem
