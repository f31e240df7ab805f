#include "engine/geometry/import/kept_mesh.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

#include "engine/base/files/byte_archive.h"
#include "engine/base/files/image_bytes.h"
#include "engine/geometry/mesh/mesh_diagnosis.h"

namespace tandem {

namespace {

/// Tells whether all of a mesh is in its file.
bool IsWhole(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  constexpr std::array kWhole{".stl", ".ply", ".off", ".3mf"};
  return std::find(kWhole.begin(), kWhole.end(), ending) != kWhole.end();
}

Result<ImportedMesh> Read(const Result<BlockFile>& mapped, const std::filesystem::path& file) {
  if (!mapped) return mapped.error();
  ImportedMesh mesh;
  ByteReader reader(mapped->blocks[0].bytes);
  std::uint8_t closed = 0;
  reader.Read(closed);
  reader.ReadArray(mesh.diagnosis);
  reader.ReadArray(mesh.mesh.vertices);
  reader.ReadArray(mesh.mesh.triangles);
  mesh.closed = closed != 0;
  const std::size_t vertices = mesh.mesh.vertices.size();
  const bool sound = reader.good() && reader.at_end() &&
                     std::all_of(mesh.mesh.triangles.begin(), mesh.mesh.triangles.end(),
                                 [vertices](const TriangleMesh::Triangle& t) {
                                   return std::max({t[0], t[1], t[2]}) < vertices;
                                 });
  if (!sound) return DamagedFile(kKeptMeshFile, file.string());
  return mesh;
}

}  // namespace

Result<ImportedMesh> ImportAndDiagnose(const std::filesystem::path& file,
                                       const ImportOptions& options) {
  Result<TriangleMesh> mesh = ImportMesh(file, options);
  if (!mesh) return mesh.error();
  const MeshDiagnosis diagnosis = Diagnose(*mesh);
  return ImportedMesh{std::move(*mesh), diagnosis.closed(), Describe(diagnosis)};
}

std::optional<BlockFileSources> KeyOf(const std::filesystem::path& file,
                                      const ImportOptions& options) {
  if (!IsWhole(file)) return std::nullopt;
  const Result<ImageBytes> bytes = ImageBytes::Map(file);
  if (!bytes) return std::nullopt;
  RunningSha256 settings;
  settings.Add(std::int64_t{options.scale ? 1 : 0});
  settings.Add(options.scale.value_or(0));
  settings.Add(options.weld_tolerance);
  settings.AddText(file.extension().string());
  settings.AddText(options.part);
  return BlockFileSources{Sha256OfMany({bytes->data(), bytes->size()}), settings.Value()};
}

std::optional<Error> KeepMesh(const ImportedMesh& mesh, const BlockFileSources& made_of,
                              const std::filesystem::path& file) {
  ByteWriter writer;
  writer.Add(static_cast<std::uint8_t>(mesh.closed ? 1 : 0));
  writer.AddArray(mesh.diagnosis);
  writer.AddArray(mesh.mesh.vertices);
  writer.AddArray(mesh.mesh.triangles);
  return SaveBlocks(kKeptMeshFile, made_of, 0, {writer.bytes(), {}}, file);
}

Result<ImportedMesh> LoadKeptMesh(const std::filesystem::path& file,
                                  const BlockFileSources& made_of) {
  return Read(MapBlocks(kKeptMeshFile, file, made_of), file);
}

std::optional<Error> KeptMeshFault(const std::filesystem::path& file) {
  const Result<ImportedMesh> mesh = Read(MapBlocks(kKeptMeshFile, file), file);
  if (!mesh) return mesh.error();
  return std::nullopt;
}

}  // namespace tandem
