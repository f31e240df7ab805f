#pragma once

#include "engine/geometry/triangle_mesh.h"

namespace tandem {

/// Takes from a closed mesh those bodies (MeshDiagnosis) whose boxes meet a box: within it they are
/// all that there is. Takes all of any other mesh, since all of it tells what is inside.
TriangleMesh BodiesMeeting(const TriangleMesh& mesh, const Bounds& box);

}  // namespace tandem
