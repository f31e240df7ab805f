// Tests good files that the mesh library reads wrong without a word, and bad ones that it reads at
// all. All are made here; each volume is known.

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "engine/base/regular_file.h"
#include "engine/geometry/mass_properties.h"
#include "engine/geometry/mesh_file.h"
#include "engine/geometry/own_readers.h"
#include "engine/geometry/polygon_split.h"
#include "tests/engine/geometry/mesh_file_samples.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;
using testing::TempFolder;
using testing::ThreeMfBox;
using testing::Zip;

std::string With(std::string text, const std::string& old, const std::string& words) {
  const std::size_t at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  return at == std::string::npos ? text : text.replace(at, old.size(), words);
}

class MisreadFiles : public ::testing::Test {
 protected:
  Result<TriangleMesh> Read(const std::string& name, const std::string& content,
                            const ImportOptions& options = {}) {
    return ImportMesh(folder_.Write(name, content), options);
  }
  void ExpectVolume(double volume, const std::string& name, const std::string& content,
                    const ImportOptions& options = {}) {
    const Result<TriangleMesh> mesh = Read(name, content, options);
    ASSERT_TRUE(mesh) << mesh.error().what;
    EXPECT_NEAR(ComputeMassProperties(*mesh).volume, volume, 1e-6 * volume) << name;
  }
  void ExpectRefused(const std::string& why, const std::string& name, const std::string& content,
                     const ImportOptions& options = {}) {
    const Result<TriangleMesh> mesh = Read(name, content, options);
    ASSERT_FALSE(mesh) << name;
    EXPECT_THAT(mesh.error().what, HasSubstr(why));
  }
  TempFolder folder_;
};

// ---- OFF ----

/// A prism on an L of area 3, 2 high, with concave faces of six corners: a volume of 6.
const std::string kOffPrism =
    "12 8 18\n0 0 0\n2 0 0\n2 1 0\n1 1 0\n1 2 0\n0 2 0\n0 0 2\n2 0 2\n2 1 2\n1 1 2\n1 2 2\n0 2 2\n"
    "6 5 4 3 2 1 0\n6 6 7 8 9 10 11\n4 0 1 7 6\n4 1 2 8 7\n4 2 3 9 8\n4 3 4 10 9\n4 4 5 11 10\n"
    "4 5 0 6 11\n";

TEST_F(MisreadFiles, OffOfPolygonsIsReadHoweverItIsWritten) {
  ExpectVolume(6, "prism.off", "OFF\n" + kOffPrism);
  ExpectVolume(6, "prism.off", "# made by hand\nOFF " + kOffPrism);
  ExpectVolume(6, "bare.off", kOffPrism);
  ExpectVolume(6, "marked.off", "\xEF\xBB\xBFOFF\n" + kOffPrism);
  std::string windows;
  for (const char c : "OFF\n" + kOffPrism)
    windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
  ExpectVolume(6, "windows.off", windows);
}

TEST_F(MisreadFiles, OffWithColoursAndNormalsIsTheSameMesh) {
  std::string coloured = "COFF\n12 8 18\n";
  std::string with_normals = "NOFF\n12 8 18\n";
  std::size_t at = kOffPrism.find('\n') + 1;
  for (int line = 0; at < kOffPrism.size(); ++line) {
    const std::size_t end = kOffPrism.find('\n', at);
    const std::string words = kOffPrism.substr(at, end - at);
    coloured += words + (line < 12 ? " 0.5 0.5 0.5 1\n" : " 255 0 0\n");
    with_normals += words + (line < 12 ? " 0 0 1\n" : "   # a face\n");
    at = end + 1;
  }
  ExpectVolume(6, "coloured.off", coloured);
  ExpectVolume(6, "normals.off", with_normals);
}

constexpr std::array<std::array<std::uint32_t, 4>, 6> kCubeFaces{
    {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};

std::string Swapped(std::uint32_t number, bool big) {
  std::string bytes;
  for (int i = 0; i < 4; ++i) bytes += static_cast<char>(number >> (8 * (big ? 3 - i : i)));
  return bytes;
}

std::string BinaryOffCube(bool big) {
  const auto whole = [big](std::uint32_t number) {
    return Swapped(number, big);
  };
  const auto real = [big](float number) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &number, 4);
    return Swapped(bits, big);
  };
  std::string file = "OFF BINARY\n" + whole(8) + whole(6) + whole(12);
  for (int i = 0; i < 8; ++i) {
    for (const int x : {i & 1, i >> 1 & 1, i >> 2 & 1}) file += real(static_cast<float>(x));
  }
  for (const auto& face : kCubeFaces) {
    file += whole(4);
    for (const std::uint32_t corner : face) file += whole(corner);
    file += whole(1) + whole(3);  // a colour of a table
  }
  return file;
}

TEST_F(MisreadFiles, BinaryOffIsReadInBothOrdersOfBytes) {
  ExpectVolume(1, "big.off", BinaryOffCube(true));
  ExpectVolume(1, "little.off", BinaryOffCube(false));
  for (std::size_t cut = 0; cut < BinaryOffCube(true).size(); cut += 7) {
    EXPECT_FALSE(Read("cut.off", BinaryOffCube(true).substr(0, cut))) << cut;
  }
}

TEST_F(MisreadFiles, OffThatIsNotWhatItSaysIsRefusedInWords) {
  ExpectRefused("is shorter than the vertices", "huge.off", "OFF\n4000000000 4000000000 0\n");
  ExpectRefused("uses vertex 12", "index.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 12\n");
  ExpectRefused("has fewer faces", "faces.off", "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  ExpectRefused("has fewer vertices", "words.off", "OFF\n3 1 0\n0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  ExpectRefused("more lines", "more.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 2\n");
  ExpectRefused("is not of three dimensions", "four.off", "4OFF\n3 1 0\n");
  ExpectRefused("it has no part 'lid'", "part.off", "OFF\n" + kOffPrism, {.part = "lid"});
}

// ---- STL ----

std::string StlCube(std::string words) {
  words.resize(80, ' ');
  std::string cube = testing::BinaryStlCube();
  return words + cube.substr(80);
}

TEST_F(MisreadFiles, BinaryStlThatBeginsWithSolidIsRead) {
  ExpectVolume(1, "solid.stl", StlCube("solid part made by a program"));
  ExpectVolume(1, "tail.stl", StlCube("solid") + "\n");
  ExpectVolume(1, "tail.stl", StlCube("made by a program") + std::string(7, '\0'));
  ExpectVolume(1, "names.stl", StlCube("solid facet normal outer loop vertex endsolid"));
}

TEST_F(MisreadFiles, TextStlStaysText) {
  const Result<TriangleMesh> mesh = Read("text.stl", testing::kAsciiStl);
  ASSERT_TRUE(mesh) << mesh.error().what;
  EXPECT_EQ(mesh->triangles.size(), 2U);
  ExpectRefused("part.stl", "part.stl", StlCube("solid").substr(0, 300));
}

// ---- PLY ----

/// Returns a cube whose binary numbers begin with bytes that end lines: its first vertex is at x =
/// 2.4e-38.
std::string BinaryPlyCube(bool big, const std::string& line_end) {
  std::string file;
  for (const char* line :
       {"ply", big ? "format binary_big_endian 1.0" : "format binary_little_endian 1.0",
        "comment made by hand", "element vertex 8", "property float x", "property float y",
        "property float z", "property uchar red", "element face 6",
        "property list uchar uint vertex_index", "property float quality", "end_header"}) {
    file += line + line_end;
  }
  for (int i = 0; i < 8; ++i) {
    for (const int x : {i & 1, i >> 1 & 1, i >> 2 & 1}) {
      const float number = i == 0 ? 0.F : static_cast<float>(x);
      std::uint32_t bits = 0;
      std::memcpy(&bits, &number, 4);
      if (i == 0 && x == 0) bits = 0x0A0A0A0A;
      file += Swapped(bits, big);
    }
    file += '\n';
  }
  for (const auto& face : kCubeFaces) {
    file += '\4';
    for (const std::uint32_t corner : face) file += Swapped(corner, big);
    file += Swapped(0x0A0A0A0A, big);
  }
  return file;
}

TEST_F(MisreadFiles, BinaryPlyIsReadWhateverItsNumbersLookLike) {
  ExpectVolume(1, "little.ply", BinaryPlyCube(false, "\n"));
  ExpectVolume(1, "big.ply", BinaryPlyCube(true, "\n"));
  ExpectVolume(1, "windows.ply", BinaryPlyCube(false, "\r\n"));
  ExpectVolume(1, "text.ply", testing::kPlyCube);
  const std::string whole = BinaryPlyCube(false, "\n");
  for (std::size_t cut = 0; cut < whole.size(); cut += 11) {
    EXPECT_FALSE(Read("cut.ply", whole.substr(0, cut))) << cut;
  }
  ExpectRefused("a face uses vertex 9", "index.ply",
                "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 9\n");
}

// ---- Text that is not plain ASCII ----

std::string Utf16(const std::string& text, bool big) {
  std::string wide = big ? "\xFE\xFF" : "\xFF\xFE";
  for (const char c : text) {
    if (big) wide += '\0';
    wide += c;
    if (!big) wide += '\0';
  }
  return wide;
}

std::string DaeTetrahedron(const std::string& count = "12", const std::string& accessor = "4",
                           const std::string& encoding = "utf-8") {
  return "<?xml version=\"1.0\" encoding=\"" + encoding +
         "\"?>\n<COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\">"
         "<asset><unit name=\"meter\" meter=\"1\"/><up_axis>Z_UP</up_axis></asset>"
         "<library_geometries><geometry id=\"g\" name=\"g\"><mesh><source id=\"p\"><float_array "
         "id=\"pa\" count=\"" +
         count +
         "\">0 0 0 1 0 0 0 1 0 0 0 1</float_array><technique_common><accessor source=\"#pa\" "
         "count=\"" +
         accessor +
         "\" stride=\"3\"><param name=\"X\" type=\"float\"/><param name=\"Y\" type=\"float\"/>"
         "<param name=\"Z\" type=\"float\"/></accessor></technique_common></source><vertices "
         "id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices><triangles count=\"4\">"
         "<input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>0 2 1 0 1 3 1 2 3 0 3 2</p>"
         "</triangles></mesh></geometry></library_geometries><library_visual_scenes><visual_scene "
         "id=\"s\"><node id=\"n\"><instance_geometry url=\"#g\"/></node></visual_scene>"
         "</library_visual_scenes><scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>";
}

TEST_F(MisreadFiles, ColladaInUtf16IsRead) {
  ExpectVolume(1.0 / 6, "plain.dae", DaeTetrahedron());
  ExpectVolume(1.0 / 6, "big.dae", Utf16(DaeTetrahedron("12", "4", "utf-16"), true));
  ExpectVolume(1.0 / 6, "little.dae", Utf16(DaeTetrahedron("12", "4", "UTF-16"), false));
}

TEST_F(MisreadFiles, ColladaWhoseArraysAreNotAsLongAsTheySayIsRefused) {
  ExpectRefused("more.dae", "more.dae", DaeTetrahedron("13"));  // the library sees that itself
  ExpectRefused("says that it has 3 numbers, and has 12", "less.dae", DaeTetrahedron("3"));
  ExpectRefused("takes 5 times 3 numbers", "beyond.dae", DaeTetrahedron("12", "5"));
}

TEST_F(MisreadFiles, ObjIsReadInUtf16BehindAMarkAndWithLongLines) {
  ExpectVolume(1, "big.obj", Utf16(testing::kObjCube, true));
  ExpectVolume(1, "little.obj", Utf16(testing::kObjCube, false));
  ExpectVolume(1, "marked.obj", "\xEF\xBB\xBF" + testing::kObjCube);
  std::string broken;  // each line goes on behind its second word
  for (std::size_t at = 0, end = 0; at < testing::kObjCube.size(); at = end + 1) {
    end = testing::kObjCube.find('\n', at);
    std::string line = testing::kObjCube.substr(at, end - at);
    line.replace(line.find(' ', 2), 1, " \\\n ");
    broken += line + "\n";
  }
  ExpectVolume(1, "broken.obj", broken);
}

// ---- Numbers that do not fit ----

const std::string kInfinite = "1 of its 8 vertices are infinite";

TEST_F(MisreadFiles, OffAndPlyNumbersBeyondAFloatAreInfinite) {
  for (const std::string number : {"1e50", "-1e50", "1e400", "1e99999999999999999999", "1e+39",
                                   "1000000000000000000000000000000000000000000000000000"}) {
    ExpectRefused(kInfinite, "huge.off", With(testing::kOffCube, "1 1 1\n4", number + " 1 1\n4"));
    ExpectRefused(kInfinite, "huge.ply", With(testing::kPlyCube, "1 1 1\n4", number + " 1 1\n4"));
  }
}

TEST_F(MisreadFiles, OffAndPlyNumbersTooSmallForAFloatAreZero) {
  for (const std::string number : {"1e-60", "-1e-400", "0.001e-99999999999999999999",
                                   "0.00000000000000000000000000000000000000000000000000000001"}) {
    ExpectVolume(1, "small.off", With(testing::kOffCube, "\n0 0 0\n", "\n0 " + number + " 0\n"));
    ExpectVolume(1, "small.ply", With(testing::kPlyCube, "\n0 0 0\n", "\n0 " + number + " 0\n"));
  }
}

TEST_F(MisreadFiles, OffAndPlyCornersBeyondAnIntegerAreRefused) {
  // 2^32 + 7, the last vertex if only 32 bits of it counted
  ExpectRefused("has a face without all its corners", "corner.off",
                With(testing::kOffCube, "4 4 5 7 6", "4 4 5 4294967303 6"));
  ExpectRefused("has fewer faces than it says", "corner.off",
                With(testing::kOffCube, "4 4 5 7 6", "99999999999999999999 4 5 7 6"));
  ExpectRefused("of its face is not whole", "corner.ply",
                With(testing::kPlyCube, "4 4 5 7 6", "4 4 5 4294967303 6"));
  ExpectRefused("of its face is not whole", "corner.ply",
                With(testing::kPlyCube, "4 4 5 7 6", "4 4 5 1e400 6"));
}

const std::string kManyDigits = "99999999999999999999999";

TEST_F(MisreadFiles, NumbersOfMoreDigitsThanTheLibraryHoldsAreRefused) {
  const std::string why = "has a number of 20 digits and more before its point";
  ExpectRefused(why, "digits.obj",
                With(testing::kObjCube, "v 1 1 1", "v 1 -" + kManyDigits + " 1"));
  ExpectRefused(why, "digits.obj",
                With(testing::kObjCube, "v 1 1 1", "v\t" + kManyDigits + ".5 1 1"));
  ExpectRefused(why, "digits.stl", With(testing::kAsciiStl, "1 1 0", kManyDigits + " 1 0"));
  ExpectRefused(why, "digits.dae", With(DaeTetrahedron(), "0 0 1</", "0 0 " + kManyDigits + "</"));
  ExpectRefused(why, "digits.dae",
                With(DaeTetrahedron(), "<instance_geometry",
                     "<translate>0 0 " + kManyDigits + "</translate><instance_geometry"));
}

TEST_F(MisreadFiles, ManyDigitsBehindAPointOrInANameAreRead) {
  const std::string zero = "0.00000000000000000000000000";
  ExpectVolume(1, "digits.obj",
               "# " + kManyDigits + "\no part_" + kManyDigits + "\n" +
                   With(testing::kObjCube, "v 0 0 0", "v " + zero + " 0 0"));
  ExpectVolume(1.0 / 6, "digits.dae",
               With(With(DaeTetrahedron(), "name=\"g\"", "name=\"" + kManyDigits + "\""), ">0 0 0 ",
                    ">0 0 " + zero + " "));
  const Result<TriangleMesh> named =
      Read("digits.stl", With(With(testing::kAsciiStl, "solid t", "solid " + kManyDigits),
                              "vertex 0 0 0", "vertex 0 0 " + zero));
  ASSERT_TRUE(named) << named.error().what;
}

// ---- glTF ----

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

TEST_F(MisreadFiles, GltfWithATriangleOfNoVerticesIsRefused) {
  ExpectRefused("1 of its 4 triangles cannot be had", "index.glb", Glb(true, 9));
}

TEST_F(MisreadFiles, GltfThatNeedsWhatIsNotReadIsRefused) {
  const auto needs = [](const std::string& names) {
    return Glb(true, 0, "{", "{\"extensionsRequired\":[" + names + "],");
  };
  ExpectVolume(1.0 / 6, "needs.glb", needs(""));
  ExpectVolume(1.0 / 6, "needs.glb", needs(R"("KHR_materials_unlit","KHR_texture_transform")"));
  for (const char* name : {"KHR_mesh_quantization", "EXT_mesh_gpu_instancing", "KHR_"}) {
    ExpectRefused("it needs " + std::string(name) + ", which is not read: export it without",
                  "needs.glb", needs(R"("KHR_materials_ior",")" + std::string(name) + "\""));
  }
  // not all that the library takes for JSON is
  ExpectRefused("what it needs cannot be read", "twice.glb",
                needs(R"("KHR_mesh_quantization"],"extensionsRequired":[)"));
  ExpectRefused("what it needs cannot be read", "number.glb", needs("7"));
}

TEST_F(MisreadFiles, GltfPlacesThatAreNotThreeFloatsAreRefused) {
  ExpectRefused("the places of its vertices are not three floats each", "short.glb",
                Glb(true, 0, "5126", "5122"));
  ExpectRefused("the places of its vertices are not three floats each", "plane.glb",
                Glb(true, 0, "VEC3", "VEC2"));
}

// ---- 3MF of several models ----

std::string Model(const std::string& inside, const std::string& unit = "millimeter",
                  const std::string& needs = "p", const std::string& spaces = "") {
  return "<?xml version=\"1.0\"?><model unit=\"" + unit +
         "\" xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" "
         "xmlns:p=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\" " +
         spaces + " requiredextensions=\"" + needs + "\">" + inside + "</model>";
}

/// Returns a box of 1 x 2 x 3 in a model of its own, put twice into the first model's object, once
/// mirrored.
std::string SeveralModels(const std::string& unit_of_part = "millimeter") {
  return Zip(
      {{"3D/parts/box.model", Model("<resources><object id=\"7\" type=\"model\" name=\"box\">" +
                                        ThreeMfBox(1, 2, 3) + "</object></resources><build/>",
                                    unit_of_part)},
       {"3D/3dmodel.model",
        Model("<resources><object id=\"1\" type=\"model\"><components>"
              "<component p:path=\"/3D/parts/box.model\" objectid=\"7\"/>"
              "<component p:path=\"/3D/parts/box.model\" objectid=\"7\" "
              "transform=\"-1 0 0 0 1 0 0 0 1 10 0 0\"/></components></object></resources>"
              "<build><item objectid=\"1\" transform=\"2 0 0 0 2 0 0 0 2 0 0 5\"/></build>")}});
}

TEST_F(MisreadFiles, A3mfFileOfSeveralModelsIsPutTogether) {
  ExpectVolume(2 * 6 * 8, "two.3mf", SeveralModels());
  ExpectVolume(2 * 6 * 8e-9, "two.3mf", SeveralModels(), {.scale = std::nullopt});
  ExpectVolume(2 * 6 * 8, "two.3mf", SeveralModels(), {.part = "box"});
  const Result<TriangleMesh> mesh = Read("two.3mf", SeveralModels());
  Bounds bounds = BoundsOf(*mesh);
  EXPECT_TRUE(bounds.min.isApprox(Vec3(0, 0, 5)) && bounds.max.isApprox(Vec3(20, 4, 11)));
  ExpectRefused("it has no part 'lid', but", "two.3mf", SeveralModels(), {.part = "lid"});
}

TEST_F(MisreadFiles, A3mfFileOfSeveralModelsThatIsWrongIsRefusedInWords) {
  ExpectRefused("several units, millimeter and inch", "unit.3mf", SeveralModels("inch"));
  const std::string circle = Model(
      "<resources><object id=\"1\"><components><component objectid=\"1\" "
      "p:path=\"/3D/3dmodel.model\"/></components></object></resources>"
      "<build><item objectid=\"1\"/></build>");
  ExpectRefused("within one another", "circle.3mf", Zip({{"3D/3dmodel.model", circle}}));
  const std::string missing =
      Model("<resources/><build><item objectid=\"1\" p:path=\"/3D/none.model\"/></build>");
  ExpectRefused("3D/none.model is missing", "none.3mf", Zip({{"3D/3dmodel.model", missing}}));
}

// The triangles in such a file may be a sketch only, or other things count in their place. Both
// files hold 14: boxes of 1, 1 and 12, or one of 1 x 2 x 7.
TEST_F(MisreadFiles, A3mfFileThatNeedsWhatIsNotReadIsRefused) {
  const std::string begin = "http://schemas.microsoft.com/3dmanufacturing/";
  const auto needs = [&](const std::string& prefixes, const std::string& space, bool several) {
    const std::string x = "xmlns:x=\"" + begin + space + "\"";
    if (!several) {
      return testing::ThreeMf(x + " xmlns:p=\"" + begin +
                              "production/2015/06\" requiredextensions=\"" + prefixes + "\"");
    }
    return Zip({{"3D/3dmodel.model",
                 Model("<resources><object id=\"1\" type=\"model\">" + ThreeMfBox(1, 2, 7) +
                           "</object></resources><build><item objectid=\"1\" "
                           "p:path=\"/3D/3dmodel.model\"/></build>",
                       "millimeter", prefixes, x)}});
  };
  for (const bool several : {false, true}) {
    ExpectVolume(14, "needs.3mf", needs("", "beamlattice/2017/02", several));
    ExpectVolume(14, "needs.3mf", needs("p x", "material/2015/02", several));
    ExpectVolume(14, "needs.3mf", needs("x p", "trianglesets/2021/07", several));
    for (const char* space : {"slice/2015/07", "beamlattice/2017/02", "securecontent/2019/04",
                              "booleanoperations/2023/07", "volumetric/2022/01"}) {
      ExpectRefused(
          "needs the extension " + begin + space + ", which is not read: export it without",
          "needs.3mf", needs("p x", space, several));
    }
    ExpectRefused("needs the extension y, which is not read", "needs.3mf",
                  needs("y", "material/2015/02", several));
  }
  const std::string part =
      Zip({{"3D/part.model", Model("<resources/><build/>", "millimeter", "x",
                                   "xmlns:x=\"" + begin + "slice/2015/07\"")},
           {"3D/3dmodel.model",
            Model("<resources/><build><item objectid=\"1\" p:path=\"/3D/part.model\"/></build>")}});
  ExpectRefused("its model 3D/part.model needs the extension", "part.3mf", part);
}

// ---- 3MF archives ----

// A box of 2 x 2 x 3 has a width of 7 by one changed byte. The archive says what its bytes add up
// to.
TEST_F(MisreadFiles, A3mfFileWhoseBytesAreNotThoseThatWerePackedIsRefused) {
  ExpectRefused("its model 3D/3dmodel.model is damaged", "flip.3mf",
                With(testing::ThreeMf("unit=\"millimeter\""), "x=\"2\" y=\"2\" z=\"3\"",
                     "x=\"7\" y=\"2\" z=\"3\""));
  ExpectRefused("its model 3D/parts/box.model is damaged", "flip.3mf",
                With(SeveralModels(), "x=\"1\" y=\"2\" z=\"3\"", "x=\"7\" y=\"2\" z=\"3\""));
}

TEST_F(MisreadFiles, A3mfFileOfWhichOnlyTheBeginningIsLeftIsRefused) {
  std::string cut = SeveralModels();
  const std::size_t entry = cut.find("PK\x01\x02");
  ASSERT_NE(entry, std::string::npos);
  // it ends where its last triangle would begin
  const std::size_t size = cut.rfind("<triangle ", cut.find("</triangles>")) - cut.find("<?xml");
  cut.replace(entry + 20, 4, testing::Bytes(size, 4));
  ExpectRefused("its model 3D/parts/box.model is damaged", "cut.3mf", cut);
}

TEST_F(MisreadFiles, A3mfFilesUnitIsThatOfTheModelItBeginsWith) {
  const std::string core = "http://schemas.microsoft.com/3dmanufacturing/";
  const auto model = [&](const std::string& unit, int size) {
    return "<?xml version=\"1.0\"?><model unit=\"" + unit + "\" xmlns=\"" + core +
           "core/2015/02\"><resources><object id=\"1\" type=\"model\">" +
           ThreeMfBox(size, size, size) +
           "</object></resources><build><item objectid=\"1\"/></build></model>";
  };
  const std::string relations =
      "<?xml version=\"1.0\"?><Relationships "
      "xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">"
      "<Relationship Target=\"/picture.png\" Id=\"r1\" Type=\"" +
      core +
      "thumbnail\"/>"
      "<Relationship Target=\"/3D/part.model\" Id=\"r0\" Type=\"" +
      core + "2013/01/3dmodel\"/></Relationships>";
  ExpectVolume(0.0254 * 0.0254 * 0.0254, "start.3mf",
               Zip({{"_rels/.rels", relations},
                    {"3D/other.model", model("millimeter", 5)},
                    {"3D/part.model", model("inch", 1)}}),
               {.scale = std::nullopt});
}

// ---- Words of a file in what is said of it ----

TEST_F(MisreadFiles, WhatIsSaidOfAFileIsPlainText) {
  // a sequence for terminals, a mark that turns the direction, half a character of UTF-16, no UTF-8
  for (const std::string name : {"\xC2\x9B"
                                 "31mred",
                                 "\xE2\x80\xAE"
                                 "dil",
                                 "\xED\xA0\x80", "\xFF\xFE"}) {
    const ImportOptions lid{.part = "lid"};
    for (const Result<TriangleMesh>& mesh :
         {Read("names.obj", "o " + name + "\n" + testing::kObjCube, lid),
          Read("names.3mf",
               Zip({{"3D/3dmodel.model", Model("<resources><object id=\"1\" name=\"" + name +
                                               "\">" + ThreeMfBox(1, 1, 1) +
                                               "</object></resources><build><item objectid=\"1\" "
                                               "p:path=\"/3D/3dmodel.model\"/></build>")}}),
               lid),
          Read("names.off", name + "OFF\n" + kOffPrism)}) {
      ASSERT_FALSE(mesh);
      EXPECT_TRUE(IsPlainText(mesh.error().what)) << mesh.error().what;
    }
  }
  // the twentieth byte is within a character
  const Result<TriangleMesh> half = Read("half.off", "abcdefghijklmnopqrs\xC3\xA4\n");
  ASSERT_FALSE(half);
  EXPECT_TRUE(IsPlainText(half.error().what)) << half.error().what;
}

// ---- Polygons ----

double AreaOf(const std::vector<FloatPoint>& points,
              const std::vector<TriangleMesh::Triangle>& triangles) {
  double area = 0;
  for (const TriangleMesh::Triangle& t : triangles) {
    const auto at = [&](std::size_t k) {
      return Vec3(points[t[k]][0], points[t[k]][1], points[t[k]][2]);
    };
    const double twice = (at(1) - at(0)).cross(at(2) - at(0)).z();
    EXPECT_GE(twice, 0);  // none is turned over
    area += twice / 2;
  }
  return area;
}

// A comb has as many ears as teeth; its area is that of the teeth and of the back.
TEST(PolygonSplit, CutsAConcavePolygonIntoItsArea) {
  std::vector<FloatPoint> points{{0, -1, 0}};
  std::vector<std::uint32_t> corners;
  constexpr int kTeeth = 50;
  points.push_back({2 * kTeeth, -1, 0});
  for (int i = kTeeth; i > 0; --i) {
    const auto x = static_cast<float>(2 * i);
    points.push_back({x, 0, 0});
    points.push_back({x - 1, 5, 0});
  }
  points.push_back({0, 0, 0});
  for (std::uint32_t i = 0; i < points.size(); ++i) corners.push_back(i);
  std::vector<TriangleMesh::Triangle> triangles;
  SplitPolygon(points, corners, triangles);
  EXPECT_EQ(triangles.size(), corners.size() - 2);
  // teeth of 2 x 5 / 2 on a back of 100 x 1
  EXPECT_NEAR(AreaOf(points, triangles), kTeeth * 5 + 2 * kTeeth, 1e-9);
}

TEST(PolygonSplit, LosesNothingOfAPolygonThatCrossesItself) {
  const std::vector<FloatPoint> points{{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::vector<std::uint32_t> corners{0, 1, 2, 3};
  std::vector<TriangleMesh::Triangle> triangles;
  SplitPolygon(points, corners, triangles);
  EXPECT_EQ(triangles.size(), 2U);
}

}  // namespace
}  // namespace tandem
