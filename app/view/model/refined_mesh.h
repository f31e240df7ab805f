#pragma once

#include <cstddef>

#include "app/view/model/shaded_mesh.h"

namespace tandem {

/// Cuts a mesh's triangles until no side is longer than `longest` (m), or it would have more than
/// `most_vertices`: colours live at vertices, and what lies between them has none of its own. The
/// surface stays where it is, without cracks; lines stay as they are. The uncut triangles are kept
/// for pictures in one colour.
void Refine(ShadedMesh& mesh, double longest, std::size_t most_vertices);

}  // namespace tandem
