#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/files/block_file.h"
#include "engine/base/result.h"
#include "engine/geometry/import/mesh_file.h"
#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// A mesh as of ImportMesh(), with its diagnosis.
struct ImportedMesh {
  TriangleMesh mesh;
  bool closed = false;               // MeshDiagnosis::closed()
  std::string diagnosis;             // text of Describe()
  std::vector<std::string> remarks;  // those of ImportMesh()
};

/// Does ImportMesh(), with its errors, and Diagnose().
Result<ImportedMesh> ImportAndDiagnose(const std::filesystem::path& file,
                                       const ImportOptions& options);

/// A mesh in a file of a cache. The version grows by one when the same file and options come to
/// give another mesh or another text.
inline constexpr BlockFileKind kKeptMeshFile{
    {'t', 'a', 'n', 'd', 'e', 'm', 'K', 'M'}, 3, "mesh of a cache"};

/// Returns a key of a mesh by its file's bytes. Returns nothing for kinds of files that name
/// others, and where the file cannot be read.
std::optional<BlockFileSources> KeyOf(const std::filesystem::path& file,
                                      const ImportOptions& options);

/// Writes a mesh to a file, whole or not at all. Returns nothing, or the error.
std::optional<Error> KeepMesh(const ImportedMesh& mesh, const BlockFileSources& made_of,
                              const std::filesystem::path& file);
/// Reads it again. Errors, in one line, are those of MapBlocks(), and a mesh of another file or
/// with other options.
Result<ImportedMesh> LoadKeptMesh(const std::filesystem::path& file,
                                  const BlockFileSources& made_of);
/// Returns what is wrong with a file, as far as that can be told without its mesh file.
std::optional<Error> KeptMeshFault(const std::filesystem::path& file);

}  // namespace tandem
