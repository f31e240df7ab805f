#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include "engine/base/result.h"
#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// Options of reading a mesh file.
struct ImportOptions {
  /// Metres per file unit; nothing: as the file declares (3MF does), else 1.
  std::optional<double> scale = 1.0;
  /// Name of the wanted node or mesh, with all below it; empty: the whole file.
  std::string part = {};
  double weld_tolerance = 0.0;                  // file units; 0 welds equal positions only
  double seconds_limit = 10.0;                  // wall time and CPU time of the reading process
  std::size_t memory_limit_bytes = 2ULL << 30;  // address space of the reading process
};

/// Reads a mesh of any format that assimp knows. Node transforms are applied, file axes are kept,
/// and vertices are welded into bodies. assimp runs in a child process with limits, because it
/// crashes on some files, even good ones. Any failure there is an error of one line.
///
/// The caller's program must hand its arguments to RunImportHelperIfAsked() first in main().
Result<TriangleMesh> ImportMesh(const std::filesystem::path& file,
                                const ImportOptions& options = {});

/// Runs the child process that ImportMesh() starts (the running program itself, called with
/// `import-helper`): reads the file, writes the mesh to the pipe and exits. In any other process it
/// returns at once.
void RunImportHelperIfAsked(int argc, char** argv);

}  // namespace tandem
