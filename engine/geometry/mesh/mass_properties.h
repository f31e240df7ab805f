#pragma once

#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// The mass distribution of a mesh, for unit mass.
struct MassProperties {
  /// Volume by the divergence theorem, for any mesh, m^3. Negative when its triangles face inwards;
  /// the rest is then as if they faced outwards.
  double volume = 0;
  Vec3 p_MBo = Vec3::Zero();  // centre of mass, m
  Mat3 unit_inertia =
      Mat3::Zero();  // about the centre of mass, M's axes, m^2: times mass gives kg m^2
  /// False when the mesh encloses no volume that can be trusted (it is open, or partly inside out).
  /// Then its mass is taken to lie evenly on its surface. Cracks that enclose almost no area do not
  /// make it open.
  bool solid = true;
};

/// Computes the properties. At least one triangle must have an area, as in every mesh of
/// ImportMesh().
MassProperties ComputeMassProperties(const TriangleMesh& mesh);

/// Computes the properties of the solid that these triangles bound as a whole, facing outwards.
/// They need not share their corners; whether they are closed is not looked at.
MassProperties ComputeBoundedMass(const TriangleMesh& boundary);

}  // namespace tandem
