#pragma once

#include <string>

#include "engine/geometry/formats/raw_mesh.h"

namespace tandem {

/// Reads a file by assimp into one list of triangles, in the reading process. `part`: the node or
/// mesh that is wanted; empty: all.
ReadAnswer ReadWithAssimp(const std::string& file, const std::string& part);

/// Makes ReadWithAssimp() tell failed allocations from faults of the file.
void NoteWhenMemoryRunsOut();

}  // namespace tandem
