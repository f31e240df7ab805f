#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.h"
#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// Options of reading a mesh file.
struct ImportOptions {
  /// Metres per file unit, in the place of what the file declares; nothing: as the file declares
  /// (3MF, AMF, COLLADA and FBX files do), else 1.
  std::optional<double> scale = 1.0;
  /// Name of the wanted node or mesh, with all below it; empty: the whole file.
  std::string part = {};
  double weld_tolerance = 0.0;                  // file units; 0 welds equal positions only
  double seconds_limit = 10.0;                  // wall time and CPU time of the reading process
  std::size_t memory_limit_bytes = 2ULL << 30;  // address space of the reading process
};

/// Reads a mesh of STL, OBJ, PLY, OFF, 3MF, AMF, glTF, COLLADA, or any other format that assimp
/// knows. Node transforms are applied, file axes are kept, and vertices are welded into bodies. The
/// readers run in a child process with limits, because assimp crashes on some files, even good
/// ones. Any failure there is an error of one line. `remarks`, unless null, get what the file says
/// and the reader does not honour, a line each.
///
/// The caller's program must hand its arguments to RunImportHelperIfAsked() first in main().
Result<TriangleMesh> ImportMesh(const std::filesystem::path& file,
                                const ImportOptions& options = {},
                                std::vector<std::string>* remarks = nullptr);

/// Runs the child process that ImportMesh() starts (the running program itself, called with
/// `import-helper`): reads the file, writes the mesh to the pipe and exits. In any other process it
/// returns at once.
void RunImportHelperIfAsked(int argc, char** argv);

}  // namespace tandem
