#include "tests/fuzz/mesh_targets.h"

#include <filesystem>
#include <string>

#include "engine/geometry/formats/gltf_buffers.h"
#include "engine/geometry/formats/package/model_3mf.h"
#include "engine/geometry/formats/native_readers.h"
#include "engine/geometry/formats/raw_mesh.h"
#include "engine/geometry/formats/text_lines.h"
#include "tests/engine/geometry/import/mesh_file_samples.h"
#include "tests/fuzz/fed_file.h"
#include "tests/support/scratch_folder.h"

namespace tandem {

namespace {

void ExpectSound(const ReadAnswer& answer) {
  if (answer.kind != ReadAnswer::Kind::kMesh) {
    TANDEM_CHECK(!answer.words.empty());
    return;
  }
  for (const TriangleMesh::Triangle& t : answer.mesh.triangles) {
    for (const std::uint32_t corner : t) TANDEM_CHECK(corner < answer.mesh.points.size());
  }
  TANDEM_CHECK(answer.remarks.size() < 64);
  for (const std::string& remark : answer.remarks) TANDEM_CHECK(!remark.empty());
}

/// Returns a file of these bytes under a name, whose ending says what it is.
std::filesystem::path Named(const char* name, std::string_view bytes) {
  static const ScratchFolder folder;
  std::filesystem::path file = folder.path() / name;
  const std::filesystem::path fed = FedFile(bytes);
  if (!std::filesystem::is_symlink(file)) std::filesystem::create_symlink(fed, file);
  return file;
}

void FeedArchive(std::string_view bytes) {
  const std::filesystem::path file = Named("fed.3mf", bytes);
  ExpectSound(Read3mf(file, ""));
  ExpectSound(Read3mf(file, "lid"));
}

}  // namespace

void FeedOff(std::string_view bytes) {
  ExpectSound(ReadOff(bytes));
}

void FeedStl(std::string_view bytes) {
  ExpectSound(ReadStl(bytes));
  ExpectSound(ReadStl(bytes, "lid"));
}

void FeedPly(std::string_view bytes) {
  ExpectSound(ReadPly(bytes));
}

void FeedObj(std::string_view bytes) {
  const std::string text = InUtf8(std::string(bytes));
  ExpectSound(ReadObj(text));
  ExpectSound(ReadObj(text, "lid"));
}

void FeedAmf(std::string_view bytes) {
  ExpectSound(ReadAmf(bytes));
  ExpectSound(ReadAmf(bytes, "lid"));
}

void FeedCollada(std::string_view bytes) {
  if (const auto answer = ReadCollada(bytes)) ExpectSound(*answer);
  if (const auto answer = ReadCollada(bytes, "lid")) ExpectSound(*answer);
}

void FeedGltf(std::string_view bytes) {
  const std::filesystem::path file = Named("fed.gltf", bytes);
  if (const auto answer = ReadGltf(std::string(bytes), file)) ExpectSound(*answer);
  if (const auto answer = ReadGltf(std::string(bytes), file, "lid")) ExpectSound(*answer);
}

void Feed3mf(std::string_view bytes) {
  FeedArchive(bytes);
  FeedArchive(testing::Zip({{"3D/3dmodel.model", std::string(bytes)}}));
}

void FeedTexts(std::string_view bytes) {
  for (const char* name : {"fed.dae", "fed.gltf", "fed.glb", "fed.x3d"}) {
    const std::filesystem::path file = Named(name, bytes);
    static_cast<void>(TextInstead(file));
    static_cast<void>(GltfBuffers(file));
  }
}

}  // namespace tandem
