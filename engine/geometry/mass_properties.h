#pragma once

#include "engine/geometry/triangle_mesh.h"

namespace tandem {

/// How a mesh's mass lies in space, for unit mass.
struct MassProperties {
  double volume = 0;             // m^3, by the divergence theorem, whatever the mesh is like
  Vec3 p_MBo = Vec3::Zero();     // centre of mass, m
  Mat3 unit_inertia = Mat3::Zero();  // about the centre of mass, M's axes, m^2: times mass gives kg m^2
  /// False when the mesh encloses no volume that can be trusted (it is open, or turned inside out in
  /// part); then its mass is taken to lie on its surface, evenly.
  bool solid = true;
};

MassProperties ComputeMassProperties(const TriangleMesh& mesh);

}  // namespace tandem
