#pragma once

#include "engine/geometry/mesh/mass_properties.h"
#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// Computes the mass properties of a mesh as ComputeMassProperties() does, except that material
/// which several of its solids share counts once. A solid is a set of triangles that are connected
/// across their sides. A single solid that crosses itself counts what it encloses twice as twice.
MassProperties ComputeUnionMass(const TriangleMesh& mesh);

}  // namespace tandem
