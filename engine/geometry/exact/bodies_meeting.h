#pragma once

#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// Takes from a closed mesh the bodies (MeshDiagnosis) whose boxes meet a box: within it there are
/// no others. Takes all of any other mesh, since all of it decides what is inside.
TriangleMesh BodiesMeeting(const TriangleMesh& mesh, const Bounds& box);

}  // namespace tandem
