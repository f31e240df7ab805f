#pragma once

#include <vector>

#include "engine/geometry/mesh/triangle_mesh.h"
#include "scenes/generators/shapes.h"

namespace tandem {

// Parts that machines are made of, closed and turned outward like all solids of
// scenes/generators/shapes.h. Any unit of length.

/// Gap between bodies that touch (mm): wide enough to stay apart in single precision, and far below
/// a voxel.
inline constexpr double kSeam = 0.3;

TriangleMesh Rotated(const TriangleMesh& mesh, const Quat& by);
TriangleMesh Scaled(const TriangleMesh& mesh, double by);

/// A straight tube about z, its rims broken by a small chamfer.
TriangleMesh Tube(double inner, double outer, double bottom, double top, int sides);

/// A spur gear about z with trapezoidal teeth and a bore.
struct GearShape {
  int teeth = 24;
  double module = 4;  // pitch diameter over teeth
  double bore = 12;   // radius
  double width = 20;  // from z = 0 up
};
TriangleMesh Gear(const GearShape& shape);

/// A rectangular plate in x and y about the origin, z from 0 to its thickness, with a square grid
/// of round holes.
struct HoleGrid {
  int columns = 4;
  int rows = 3;
  double pitch = 40;
  double hole_radius = 12;
  double thickness = 6;
  int steps_per_side = 6;  // a hole has four times as many corners
};
TriangleMesh PerforatedPlate(const HoleGrid& grid);

/// A helical spring about z from 0 up.
TriangleMesh Spring(double radius, double wire_radius, double pitch, int turns, int sides);

/// A rack along x whose teeth point to +z, their tops at z = 0; it is `depth` deep below them and
/// `width` wide, about y = 0. Its ends are flat and at x = -+length / 2.
struct RackShape {
  double length = 600;
  double width = 12;
  double depth = 24;
  double tooth_pitch = 10;
  double tooth_height = 5;
};
TriangleMesh Rack(const RackShape& shape);

/// Hexagonal heads with their washers on z = 0, evenly on a circle about z.
TriangleMesh BoltCircle(int bolts, double circle_radius, double across_flats);

}  // namespace tandem
