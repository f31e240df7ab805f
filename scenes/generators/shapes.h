#pragma once

#include <vector>

#include <Eigen/Core>

#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

using Vec2 = Eigen::Vector2d;

// Solids for the generated scenes: closed, turned outward, with one vertex for every corner, and
// always the same bytes. Any unit of length.

/// Returns a closed mesh with its triangles turned round if they face inward.
TriangleMesh TurnedOutward(TriangleMesh mesh);

/// A closed row of points.
using Loop = std::vector<Vec3>;

/// Returns points on a circle about the z axis, the first on the x axis.
Loop Circle(double radius, double z, int sides);

enum class SkinEnds { kCapped, kJoined };

/// Returns the skin over loops of equally many points, each joined to the next. kCapped closes the
/// first and the last with a flat fan; kJoined joins the last to the first, as in a ring.
TriangleMesh Skin(const std::vector<Loop>& loops, SkinEnds ends);

/// Returns a solid of revolution about z. The profile is (radius, z), radii above 0; its ends are
/// closed flat.
TriangleMesh Revolved(const std::vector<Vec2>& profile, int sides);

/// Returns a ring about z: the closed profile (radius, z) goes all the way round.
TriangleMesh RevolvedRing(const std::vector<Vec2>& profile, int sides);

/// Extrudes a polygon without holes, counter-clockwise, along z from `bottom` to `top`.
TriangleMesh Prism(const std::vector<Vec2>& polygon, double bottom, double top);

TriangleMesh Box(const Vec3& min, const Vec3& max);

/// Returns a round hose of that radius along a smooth curve through the points, its ends closed
/// flat. Its radius swells and falls by `ripple`, once every two segments, as a corrugated hose
/// does.
TriangleMesh Hose(const std::vector<Vec3>& points, double radius, double ripple, int sides,
                  int segments_per_span);

/// A disc. The convex hull of an outline's discs is the outline round the origin: one disc is a
/// circle, two are a slot, four of radius 0 a rectangle.
struct Disc {
  Vec2 centre;
  double radius;
};
using Outline = std::vector<Disc>;

/// Returns the distance of the outline from the origin in the direction of that angle (rad).
double Reach(const Outline& outline, double angle);

/// A plate between two heights with one hole, both about the z axis, their edges rounded.
struct PlateEdges {
  double outer_round = 0;
  double hole_round = 0;
  int sides = 96;     // a multiple of 8
  int arc_steps = 3;  // steps of a rounded edge
};
TriangleMesh Plate(const Outline& outline, const Outline& hole, double bottom, double top,
                   const PlateEdges& edges);

/// Returns a bolt's hexagonal head with its washer face, standing on z = 0, of that width across
/// flats.
TriangleMesh HexHead(double across_flats, double height);

/// Returns the threaded end of a bolt from z = 0 down to -length.
TriangleMesh ThreadedEnd(double radius, double pitch, double length, int sides);

TriangleMesh Moved(const TriangleMesh& mesh, const Vec3& by);
/// Permutes axes: what pointed along z points along x (or y).
TriangleMesh AlongX(const TriangleMesh& mesh);
TriangleMesh AlongY(const TriangleMesh& mesh);

/// Returns the sphere of 8 * 4^levels triangles that an octahedron becomes when each edge is halved
/// `levels` times and its corners are put on the sphere. `lower_half` keeps z <= 0, which is open.
TriangleMesh OctahedralSphere(double radius, int levels, bool lower_half);

/// Returns a half sphere's wall between two radii, open to +z: two halves of octahedral spheres and
/// a flat rim.
TriangleMesh HalfCup(double inner_radius, double outer_radius, int levels);

}  // namespace tandem
