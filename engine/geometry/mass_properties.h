#pragma once

#include "engine/geometry/triangle_mesh.h"

namespace tandem {

/// How a mesh's mass lies in space, for unit mass.
struct MassProperties {
  /// By the divergence theorem, whatever the mesh is like, m^3. Negative when its triangles face
  /// inwards; the rest is then what it would be if they faced outwards.
  double volume = 0;
  Vec3 p_MBo = Vec3::Zero();  // centre of mass, m
  Mat3 unit_inertia =
      Mat3::Zero();  // about the centre of mass, M's axes, m^2: times mass gives kg m^2
  /// False when the mesh encloses no volume that can be trusted (it is open, or turned inside out
  /// in part); then its mass is taken to lie on its surface, evenly. Cracks that enclose next to no
  /// area do not make it open.
  bool solid = true;
};

/// At least one triangle must have an area, as in every mesh that ImportMesh() returns.
MassProperties ComputeMassProperties(const TriangleMesh& mesh);

}  // namespace tandem
