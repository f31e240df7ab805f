#pragma once

#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// Returns a wheel about z, its brake at positive z (mm).
TriangleMesh BrakedWheel(double axle_radius);

/// Returns a bar with an eye at each end, from z = 0 to `length`; its eyes' pins lie along y.
TriangleMesh BraceLink(double length, double radius, double eye);

}  // namespace tandem
