#pragma once

#include <cstddef>

#include "app/view/model/scene/shaded_mesh.h"

namespace tandem {

/// Cuts a mesh's triangles until no side is longer than `longest` (m), or until a further round
/// would exceed `most_vertices`. Colours live at vertices, so long sides would hide their changes.
/// The surface keeps its shape, without cracks; edge lines stay. The uncut triangles are kept for
/// pictures in one colour.
void Refine(ShadedMesh& mesh, double longest, std::size_t most_vertices);

}  // namespace tandem
