#pragma once

#include "engine/geometry/triangle_mesh.h"

namespace tandem {

/// Of a closed mesh those bodies (MeshDiagnosis) whose boxes meet a box: within it they are all
/// that there is. Of any other mesh everything, as what is inside of it is told by all of it.
TriangleMesh BodiesMeeting(const TriangleMesh& mesh, const Bounds& box);

}  // namespace tandem
