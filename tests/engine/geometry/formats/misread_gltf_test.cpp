// Tests glTF files that the mesh library reads wrong without a word.
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/engine/geometry/formats/misread_files.h"

namespace tandem {
namespace {

using testing::MisreadFiles;
using testing::With;

/// Returns one triangle, or a tetrahedron, in the smallest file there can be; `index` is that of a
/// corner.
std::string Glb(bool whole, std::uint16_t index = 0, const std::string& old = "{",
                const std::string& instead = "{") {
  const std::vector<std::uint16_t> corners =
      whole ? std::vector<std::uint16_t>{0, 2, 1, 0, 1, 3, 1, 2, 3, index, 3, 2}
            : std::vector<std::uint16_t>{0, 1, 2};
  std::string data;
  for (const float x : {0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F}) {
    data.append(reinterpret_cast<const char*>(&x), 4);
  }
  const std::size_t points = data.size();
  for (const std::uint16_t corner : corners) data.append(reinterpret_cast<const char*>(&corner), 2);
  while (data.size() % 4 != 0) data += '\0';
  std::string json =
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"accessors":[)"
      R"({"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,1]},)"
      R"({"bufferView":1,"componentType":5123,"count":)" +
      std::to_string(corners.size()) +
      R"(,"type":"SCALAR"}],"bufferViews":[{"buffer":0,"byteLength":)" + std::to_string(points) +
      R"(},{"buffer":0,"byteOffset":)" + std::to_string(points) + R"(,"byteLength":)" +
      std::to_string(2 * corners.size()) + R"(}],"buffers":[{"byteLength":)" +
      std::to_string(data.size()) + "}]}";
  json = With(json, old, instead);
  while (json.size() % 4 != 0) json += ' ';
  const auto number = [](std::size_t n) {
    return testing::Bytes(n, 4);
  };
  return "glTF" + number(2) + number(28 + json.size() + data.size()) + number(json.size()) +
         "JSON" + json + number(data.size()) + std::string("BIN\0", 4) + data;
}

TEST_F(MisreadFiles, SmallGlbIsRead) {
  ExpectVolume(1.0 / 6, "small.glb", Glb(true));
  const Result<TriangleMesh> one = Read("one.glb", Glb(false));
  ASSERT_TRUE(one) << one.error().what;
  EXPECT_EQ(one->triangles.size(), 1U);
}

TEST_F(MisreadFiles, GltfWithInvalidVertexIndicesIsRefused) {
  ExpectRefused("1 of its 4 triangles cannot be had", "index.glb", Glb(true, 9));
}

TEST_F(MisreadFiles, GltfWithRequiredExtensionsIsRefused) {
  const auto needs = [](const std::string& names) {
    return Glb(true, 0, "{", "{\"extensionsRequired\":[" + names + "],");
  };
  ExpectVolume(1.0 / 6, "needs.glb", needs(""));
  ExpectVolume(1.0 / 6, "needs.glb", needs(R"("KHR_materials_unlit","KHR_texture_transform")"));
  for (const char* name : {"EXT_meshopt_compression", "MSFT_lod", "KHR_"}) {
    ExpectRefused("it needs " + std::string(name) + ", which is not read: export it without",
                  "needs.glb", needs(R"("KHR_materials_ior",")" + std::string(name) + "\""));
  }
  // not all that the library takes for JSON is
  ExpectRefused("what it needs cannot be read", "twice.glb",
                needs(R"("KHR_mesh_quantization"],"extensionsRequired":[)"));
  ExpectRefused("what it needs cannot be read", "number.glb", needs("7"));
}

TEST_F(MisreadFiles, GltfPositionsOtherThanThreeFloatsAreRefused) {
  ExpectRefused("the places of its vertices are not three floats each", "short.glb",
                Glb(true, 0, "5126", "5122"));
  ExpectRefused("the places of its vertices are not three floats each", "plane.glb",
                Glb(true, 0, "VEC3", "VEC2"));
}

}  // namespace
}  // namespace tandem
