#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "engine/base/block_file.h"
#include "engine/base/result.h"
#include "engine/geometry/mesh_file.h"
#include "engine/geometry/triangle_mesh.h"

namespace tandem {

/// A mesh as ImportMesh() gives it, with what is to be said of it.
struct ImportedMesh {
  TriangleMesh mesh;
  bool closed = false;    // MeshDiagnosis::closed()
  std::string diagnosis;  // Describe() of it
};

/// ImportMesh(), with its errors, and Diagnose().
Result<ImportedMesh> ImportAndDiagnose(const std::filesystem::path& file,
                                       const ImportOptions& options);

/// A mesh in a file of a cache. The version grows by one when the same file and options come to
/// another mesh or to other words.
inline constexpr BlockFileKind kKeptMeshFile{
    {'t', 'a', 'n', 'd', 'e', 'm', 'K', 'M'}, 1, "mesh of a cache"};

/// Identifies a mesh by its file's bytes. Nothing of kinds that name other files, and where the
/// file cannot be read.
std::optional<MadeOf> KeyOf(const std::filesystem::path& file, const ImportOptions& options);

/// Writes a mesh to a file, whole or not at all. Nothing, or what went wrong.
std::optional<Error> KeepMesh(const ImportedMesh& mesh, const MadeOf& made_of,
                              const std::filesystem::path& file);
/// Reads it again. Refused in one line: what MapBlocks() refuses, and a mesh of another file or
/// with other options.
Result<ImportedMesh> LoadKeptMesh(const std::filesystem::path& file, const MadeOf& made_of);
/// Tells what is wrong with a file, as far as that can be told without its mesh file.
std::optional<Error> KeptMeshFault(const std::filesystem::path& file);

}  // namespace tandem
