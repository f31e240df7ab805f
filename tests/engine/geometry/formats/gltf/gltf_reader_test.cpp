// Tests what glTF files say of where and how often a mesh stands, and in what shape. All meshes are
// made of a tetrahedron of volume 1/6.
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/geometry/formats/native_readers.h"
#include "tests/engine/geometry/formats/gltf/gltf_file.h"
#include "tests/engine/geometry/formats/read_answers.h"

namespace tandem {
namespace {

using testing::ExpectNot;
using testing::ExpectRead;
using testing::ExpectReadWith;
using testing::GltfFile;
using testing::kTetra;
using testing::kTetraCorners;
using testing::kTetraPoints;
using testing::TempFolder;

ReadAnswer ReadGlb(const std::string& bytes, const std::string& part = "") {
  return *ReadGltf(bytes, "part.glb", part);
}

/// Returns the mesh with these attributes, the corners of accessor `corners`, and more words.
std::string GltfMesh(const std::string& attributes, const std::string& corners,
                     const std::string& more = "", const std::string& of_mesh = "") {
  return R"("meshes":[{"name":"shape","primitives":[{"attributes":{)" + attributes +
         R"(},"indices":)" + corners + more + "}]" + of_mesh + "}]";
}

std::string GltfNode(const std::string& more) {
  return R"("nodes":[{"name":"one","mesh":0)" + more + "}]";
}

/// Returns a tetrahedron on a node with these words, and these at the top.
std::string GltfTetra(const std::string& node, const std::string& top = "") {
  GltfFile file;
  const std::string points = file.Floats(kTetraPoints);
  const std::string corners = file.Corners(kTetraCorners);
  return file.Glb(top + GltfNode(node) + "," + GltfMesh("\"POSITION\":" + points, corners));
}

Bounds BoundsOfAnswer(const ReadAnswer& answer) {
  Bounds bounds;
  for (const FilePoint& p : answer.mesh.points) bounds.Add(Vec3(p[0], p[1], p[2]));
  return bounds;
}

TEST(GltfReader, NodesPlaceTheirMeshes) {
  ExpectRead(kTetra, ReadGlb(GltfTetra("")));
  // a quarter turn about z, then twice as large, then moved: (x, y, z) to (5 - 2 y, 2 x, 2 z)
  const std::string half = "0.7071067811865476";
  const ReadAnswer turned = ReadGlb(GltfTetra(",\"rotation\":[0,0," + half + "," + half +
                                              R"(],"scale":[2,2,2],"translation":[5,0,0])"));
  ExpectRead(8 * kTetra, turned);
  EXPECT_TRUE(BoundsOfAnswer(turned).min.isApprox(Vec3(3, 0, 0)));
  EXPECT_TRUE(BoundsOfAnswer(turned).max.isApprox(Vec3(5, 2, 2)));
  // a mirror turns the triangles round
  ExpectRead(6 * kTetra, ReadGlb(GltfTetra(R"(,"scale":[-1,2,3])")));
  const ReadAnswer matrix = ReadGlb(GltfTetra(R"(,"matrix":[1,0,0,0,0,2,0,0,0,0,3,0,7,8,9,1])"));
  ExpectRead(6 * kTetra, matrix);
  EXPECT_TRUE(BoundsOfAnswer(matrix).max.isApprox(Vec3(8, 10, 12)));
  ExpectNot("last row", ReadGlb(GltfTetra(R"(,"matrix":[1,0,0,1,0,1,0,0,0,0,1,0,0,0,0,1])")));
}

TEST(GltfReader, MatrixBesideOtherPlacingsIsRefused) {
  const std::string matrix = R"(,"matrix":[1,0,0,0,0,2,0,0,0,0,3,0,7,8,9,1])";
  for (const char* more :
       {R"(,"translation":[1,0,0])", R"(,"scale":[2,2,2])", R"(,"rotation":[0,0,0,1])"}) {
    ExpectNot("a node has a matrix and a translation, rotation or scale besides",
              ReadGlb(GltfTetra(matrix + more)));
  }
}

TEST(GltfReader, NamesOfAnyWordsAreNoFault) {
  const auto with_name = [](const std::string& name) {
    GltfFile file;
    const std::string points = file.Floats(kTetraPoints);
    const std::string corners = file.Corners(kTetraCorners);
    return file.Glb(R"("nodes":[{"mesh":0,"name":")" + name + R"("}],)" + R"("meshes":[{"name":")" +
                    name + R"(","primitives":[{"attributes":{"POSITION":)" + points +
                    R"(},"indices":)" + corners + "}]}]");
  };
  for (const std::string& name :
       {std::string("a\\tb"), std::string("a\\u0007b"), std::string(5000, 'a'), std::string()}) {
    ExpectRead(kTetra, ReadGlb(with_name(name)));
    ExpectRead(kTetra, ReadGlb(with_name(name), name.empty() ? "" : "nodes[0]"));
  }
  ExpectRead(kTetra, ReadGlb(with_name(R"(a \"b\" \\ c)"), R"(a "b" \ c)"));
}

TEST(GltfReader, NodesWithinOneAnotherAreRefused) {
  GltfFile file;
  const std::string mesh =
      GltfMesh("\"POSITION\":" + file.Floats(kTetraPoints), file.Corners(kTetraCorners));
  ExpectNot("within one another",
            ReadGlb(file.Glb(R"("nodes":[{"children":[1]},{"children":[0],"mesh":0}],)" + mesh)));
  ExpectNot("is missing, or has several parents",
            ReadGlb(file.Glb(R"("nodes":[{"children":[2]},{"children":[2]},{"mesh":0}],)" + mesh)));
}

// ---- Instances ----

TEST(GltfReader, InstancesAreAllRead) {
  const auto instanced = [](const std::string& node, const std::string& top) {
    GltfFile file;
    const std::string mesh =
        GltfMesh("\"POSITION\":" + file.Floats(kTetraPoints), file.Corners(kTetraCorners));
    const std::string moves = file.Floats({0, 0, 0, 5, 0, 0, 10, 0, 0});
    const std::string sizes = file.Floats({1, 1, 1, 2, 2, 2, 1, 1, 3});
    return file.Glb(
        top +
        GltfNode(node +
                 R"(,"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":)" +
                 moves + R"(,"SCALE":)" + sizes + "}}}") +
        "," + mesh);
  };
  const std::string used = R"("extensionsUsed":["EXT_mesh_gpu_instancing"],)";
  const ReadAnswer three = ReadGlb(instanced("", used));
  ExpectRead((1 + 8 + 3) * kTetra, three);
  EXPECT_TRUE(BoundsOfAnswer(three).max.isApprox(Vec3(11, 2, 3)));
  // the node places its instances
  ExpectRead((1 + 8 + 3) * 8 * kTetra, ReadGlb(instanced(R"(,"scale":[2,2,2])", used)));
  ExpectRead((1 + 8 + 3) * kTetra,
             ReadGlb(instanced("", R"("extensionsRequired":["EXT_mesh_gpu_instancing"],)" + used)));
}

// ---- Shapes at rest ----

TEST(GltfReader, MorphTargetsHaveTheirDefaultWeights) {
  const auto morphed = [](const std::string& of_node, const std::string& of_mesh) {
    GltfFile file;
    const std::string points = file.Floats(kTetraPoints);
    const std::string corners = file.Corners(kTetraCorners);
    // one target moves the top up by 1, the other moves the corner on x out by 2
    const std::string up = file.Floats({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1});
    const std::string out = file.Floats({0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0});
    return file.Glb(GltfNode(of_node) + "," +
                    GltfMesh("\"POSITION\":" + points, corners,
                             R"(,"targets":[{"POSITION":)" + up + R"(},{"POSITION":)" + out + "}]",
                             of_mesh));
  };
  ExpectRead(kTetra, ReadGlb(morphed("", "")));
  ExpectRead(2 * kTetra, ReadGlb(morphed("", R"(,"weights":[1,0])")));
  ExpectRead(1.5 * 2 * kTetra, ReadGlb(morphed("", R"(,"weights":[0.5,0.5])")));
  ExpectRead(3 * kTetra, ReadGlb(morphed(R"(,"weights":[0,1])", R"(,"weights":[1,0])")));
}

TEST(GltfReader, SkinsAreHeldByTheirJoints) {
  GltfFile file;
  const std::string points = file.Floats(kTetraPoints);
  const std::string corners = file.Corners(kTetraCorners);
  const std::string joints = file.Add(
      std::vector<std::uint8_t>{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0}, "VEC4", 5121);
  const std::string weights = file.Floats({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  std::vector<float> binds(32, 0.F);
  for (const std::size_t i : {0U, 5U, 10U, 15U, 16U, 21U, 26U, 31U}) binds[i] = 1;
  const std::string inverse = file.Floats(binds, "MAT4");
  // the second joint stands 4 above the first: the top is at 5. The node's own place does not
  // count.
  const std::string nodes =
      R"("nodes":[{"mesh":0,"skin":0,"translation":[9,9,9]},{"children":[2]},{"translation":[0,0,4]}],)"
      R"("skins":[{"joints":[1,2],"inverseBindMatrices":)" +
      inverse + "}],";
  const auto mesh_of = [&](const std::string& of_joints, const std::string& of_weights) {
    return GltfMesh(
        "\"POSITION\":" + points + ",\"JOINTS_0\":" + of_joints + ",\"WEIGHTS_0\":" + of_weights,
        corners);
  };
  const ReadAnswer skinned = ReadGlb(file.Glb(nodes + mesh_of(joints, weights)));
  ExpectRead(5 * kTetra, skinned);
  EXPECT_TRUE(BoundsOfAnswer(skinned).max.isApprox(Vec3(1, 1, 5)));

  // the top hangs on no joint: the node places it
  const std::string none = file.Floats({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0}, "VEC4");
  const ReadAnswer free = ReadGlb(file.Glb(nodes + mesh_of(joints, none)));
  ExpectReadWith(10 * kTetra, "1 vertex of a skin hangs on no joint: read where its node stands",
                 free);
  EXPECT_TRUE(BoundsOfAnswer(free).max.isApprox(Vec3(9, 9, 10)));

  // joints are whole numbers
  const std::string floats = file.Floats(std::vector<float>(16, 0.F), "VEC4");
  const std::string not_numbers = file.Floats(std::vector<float>(16, NAN), "VEC4");
  const std::string shares =
      file.Add(std::vector<std::uint8_t>(16, 0), "VEC4", 5121, ",\"normalized\":true");
  for (const std::string& wrong : {floats, not_numbers, shares}) {
    ExpectNot("the joints of a skin are not numbers of joints",
              ReadGlb(file.Glb(nodes + mesh_of(wrong, weights))));
  }
}

TEST(GltfReader, InstancesOfASkinAreTold) {
  GltfFile file;
  const std::string points = file.Floats(kTetraPoints);
  const std::string corners = file.Corners(kTetraCorners);
  const std::string joints = file.Add(std::vector<std::uint8_t>(16, 0), "VEC4", 5121);
  const std::string weights = file.Floats({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  const std::string moves = file.Floats({0, 0, 0, 5, 0, 0});
  ExpectReadWith(
      kTetra, "1 node of a skin has instances that are not read: the skin is read once",
      ReadGlb(file.Glb(
          R"("nodes":[{"mesh":0,"skin":0,"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":)" +
          moves + R"(}}}},{}],"skins":[{"joints":[1]}],)" +
          GltfMesh(
              "\"POSITION\":" + points + ",\"JOINTS_0\":" + joints + ",\"WEIGHTS_0\":" + weights,
              corners))));
}

// ---- Numbers ----

TEST(GltfReader, SparseNumbersReplaceOthers) {
  GltfFile file;
  const std::string indices = file.AddView(std::vector<std::uint16_t>{1, 3});
  const std::string values = file.AddView(std::vector<float>{2, 0, 0, 0, 0, 3});
  const std::string points =
      file.Floats(kTetraPoints, "VEC3",
                  R"(,"sparse":{"count":2,"indices":{"bufferView":)" + indices +
                      R"(,"componentType":5123},"values":{"bufferView":)" + values + "}}");
  const std::string corners = file.Corners(kTetraCorners);
  ExpectRead(6 * kTetra,
             ReadGlb(file.Glb(GltfNode("") + "," + GltfMesh("\"POSITION\":" + points, corners))));
}

TEST(GltfReader, QuantizedPositionsAreRead) {
  GltfFile file;
  const std::string points =
      file.Add(std::vector<std::int16_t>{0, 0, 0, 32767, 0, 0, 0, 32767, 0, 0, 0, 32767}, "VEC3",
               5122, ",\"normalized\":true");
  const std::string corners = file.Corners(kTetraCorners);
  const std::string mesh =
      GltfNode(R"(,"scale":[1,2,3])") + "," + GltfMesh("\"POSITION\":" + points, corners);
  ExpectRead(
      6 * kTetra,
      ReadGlb(file.Glb(
          R"("extensionsUsed":["KHR_mesh_quantization"],"extensionsRequired":["KHR_mesh_quantization"],)" +
          mesh)));
  ExpectNot("are not three floats each", ReadGlb(file.Glb(mesh)));
}

TEST(GltfReader, StripsAndFansAreReadWithTheirTurns) {
  GltfFile file;
  const std::string points = file.Floats(kTetraPoints);
  // a strip round three faces, and a fan of the fourth
  const std::string strip = file.Corners({0, 1, 3, 2, 0, 1});
  ExpectRead(kTetra, ReadGlb(file.Glb(GltfNode("") + "," +
                                      GltfMesh("\"POSITION\":" + points, strip, ",\"mode\":5"))));
  const std::string fan = file.Corners({3, 0, 1, 2, 0});
  const std::string below = file.Corners({0, 2, 1});
  const std::string both = R"("meshes":[{"primitives":[{"attributes":{"POSITION":)" + points +
                           R"(},"indices":)" + fan + R"(,"mode":6},{"attributes":{"POSITION":)" +
                           points + R"(},"indices":)" + below + "}]}]";
  ExpectRead(kTetra, ReadGlb(file.Glb(GltfNode("") + "," + both)));
}

TEST(GltfReader, CornersMayBeInTheOrderOfThePoints) {
  GltfFile file;
  std::vector<float> soup;
  for (const std::uint16_t corner : kTetraCorners) {
    for (std::size_t k = 0; k < 3; ++k) soup.push_back(kTetraPoints[3 * corner + k]);
  }
  const std::string points = file.Floats(soup);
  ExpectRead(kTetra, ReadGlb(file.Glb(GltfNode("") +
                                      R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":)" +
                                      points + "}}]}]")));
}

// ---- Buffers ----

TEST(GltfReader, BufferNamesMayHavePercentCodes) {
  GltfFile file;
  const std::string points = file.Floats(kTetraPoints);
  const std::string corners = file.Corners(kTetraCorners);
  const std::string rest = GltfNode("") + "," + GltfMesh("\"POSITION\":" + points, corners);
  const TempFolder folder;
  folder.Write("my buffer \xC3\xA4.bin", file.data());
  folder.Write("100%25.bin", file.data());
  const auto read = [&](const std::string& uri) {
    return *ReadGltf(file.Json(rest, "\"uri\":\"" + uri + "\","), folder.path() / "a b.gltf");
  };
  ExpectRead(kTetra, read("my%20buffer%20%C3%A4.bin"));
  ExpectRead(kTetra, read("./my%20buffer%20%c3%a4.bin"));
  ExpectRead(kTetra, read("my buffer \xC3\xA4.bin"));
  ExpectRead(kTetra, read("100%25.bin"));
  ExpectNot("is the file none.bin, which is not there: put it beside the mesh", read("none.bin"));
  ExpectNot("is no file in its folder", read("%2E%2E/secret.bin"));
  ExpectNot("is no file in its folder", read("%2Fetc%2Fpasswd"));
  ExpectNot("is no file in its folder", read("a%0Ab.bin"));
}

TEST(GltfReader, NumbersInTheTextAreRead) {
  GltfFile file;
  const std::string points = file.Floats(kTetraPoints);
  std::string bytes;
  for (const char c : file.data()) {
    constexpr const char* kDigits = "0123456789abcdef";
    const auto byte = static_cast<unsigned char>(c);
    bytes += std::string("%") + kDigits[byte >> 4U] + kDigits[byte & 15U];
  }
  const std::string rest = GltfNode("") +
                           R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":)" + points +
                           R"(}}]}])";
  const ReadAnswer answer = *ReadGltf(
      file.Json(rest, "\"uri\":\"data:application/octet-stream," + bytes + "\","), "a.gltf");
  ASSERT_EQ(answer.kind, ReadAnswer::Kind::kMesh) << answer.words;
  ASSERT_EQ(answer.mesh.points.size(), 4U);
  EXPECT_EQ(answer.mesh.points[3], (FilePoint{0, 0, 1}));
}

// ---- What is told ----

TEST(GltfReader, WhatIsNotHonouredIsTold) {
  ExpectReadWith(kTetra, "it uses MSFT_lod, which is not read: its shape is read without",
                 ReadGlb(GltfTetra("", R"("extensionsUsed":["MSFT_lod","KHR_materials_ior"],)")));
  ExpectReadWith(kTetra, "its animations are not played: its rest pose is read",
                 ReadGlb(GltfTetra("", R"("animations":[{"channels":[],"samplers":[]}],)")));
  ExpectReadWith(kTetra, "scene 1 of its 2 scenes is read, the others are not",
                 ReadGlb(GltfTetra("", R"("scene":1,"scenes":[{"nodes":[]},{"nodes":[0]}],)")));
  ExpectRead(kTetra, ReadGlb(GltfTetra(
                         "", R"("extensionsUsed":["KHR_materials_ior","KHR_lights_punctual"],)")));
}

TEST(GltfReader, PackedTrianglesAreRefused) {
  const std::string packed =
      R"("extensionsUsed":["KHR_draco_mesh_compression"],"extensionsRequired":["KHR_draco_mesh_compression"],"nodes":[{"mesh":0}],)"
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"extensions":{"KHR_draco_mesh_compression":{"bufferView":0,"attributes":{"POSITION":0}}}}]}])";
  GltfFile file;
  file.AddAccessor("", 4, "VEC3", 5126, "");
  file.AddAccessor("", 12, "SCALAR", 5123, "");
  file.AddView(std::vector<std::uint8_t>{1, 2, 3, 4});
  ExpectNot("they are packed (KHR_draco_mesh_compression); export it without compression",
            ReadGlb(file.Glb(packed)));
}

TEST(GltfReader, TooManyValuesAreRefusedInItsWords) {
  std::string many = R"({"asset":{"version":"2.0"},"nodes":[)";
  for (int i = 0; i < 1'100'000; ++i) many += i == 0 ? "{\"a\":1}" : ",{\"a\":1}";
  const ReadAnswer answer = *ReadGltf(many + "]}", "a.gltf");
  ExpectNot("more than 2000000 values: export it in several files", answer);
  EXPECT_THAT(answer.words, ::testing::Not(::testing::HasSubstr("Tandem")));
}

TEST(GltfReader, PartsAreNodesAndMeshes) {
  ExpectRead(kTetra, ReadGlb(GltfTetra(""), "one"));
  ExpectRead(kTetra, ReadGlb(GltfTetra(""), "shape"));
  ExpectNot("it has no part 'lid', but one", ReadGlb(GltfTetra(""), "lid"));
}

}  // namespace
}  // namespace tandem
