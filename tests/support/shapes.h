#pragma once

#include <array>
#include <random>
#include <vector>

#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem::testing {

/// Returns a closed box of `size` about the origin, 12 triangles.
TriangleMesh Box(const Vec3& size);

/// Returns a closed sphere: an octahedron whose triangles are cut into four `levels` times.
TriangleMesh Sphere(double radius, int levels);

/// Returns a cube of `side` about the origin with a round hollow inside.
TriangleMesh HollowBlock(double side, double radius);

/// Returns a single square sheet of side `side` in the plane z = 0: open.
TriangleMesh Sheet(double side);

/// Returns a polygon in x and y, counter-clockwise and seen whole from its first corner, raised
/// from z = 0 to a prism. Lengths are in units of `unit` metres.
TriangleMesh Raised(const std::vector<std::array<double, 2>>& polygon, double height, double unit);

/// Returns a mesh turned and then put somewhere.
inline TriangleMesh At(const TriangleMesh& mesh, const Vec3& p, const Quat& q = Quat::Identity()) {
  return Transformed(mesh, {q, p});
}

Quat RandomRotation(std::mt19937_64& random);
Vec3 RandomDirection(std::mt19937_64& random);

/// Returns a number uniform in [low, high).
double Uniform(std::mt19937_64& random, double low, double high);

}  // namespace tandem::testing
