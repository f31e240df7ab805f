// Tests good files that the mesh library reads wrong without a word, and bad ones that it reads at
// all. All are made here; each volume is known.

#include "tests/engine/geometry/formats/misread_files.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <string>

#include <gtest/gtest.h>

#include "engine/base/files/regular_file.h"

namespace tandem {
namespace {

using testing::kOffPrism;
using testing::MisreadFiles;
using testing::ThreeMfBox;
using testing::ThreeMfModel;
using testing::With;
using testing::Zip;

// ---- OFF ----

TEST_F(MisreadFiles, OffWithPolygonsIsReadInAnyLayout) {
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

TEST_F(MisreadFiles, BinaryOffIsReadInBothByteOrders) {
  ExpectVolume(1, "big.off", BinaryOffCube(true));
  ExpectVolume(1, "little.off", BinaryOffCube(false));
  for (std::size_t cut = 0; cut < BinaryOffCube(true).size(); cut += 7) {
    EXPECT_FALSE(Read("cut.off", BinaryOffCube(true).substr(0, cut))) << cut;
  }
}

TEST_F(MisreadFiles, InconsistentOffIsRefusedWithAReason) {
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

TEST_F(MisreadFiles, BinaryStlBeginningWithSolidIsRead) {
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

TEST_F(MisreadFiles, BinaryPlyIsReadForAnyByteValues) {
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

TEST_F(MisreadFiles, ColladaWithWrongArrayLengthsIsRefused) {
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

// The mesh library would read some of the digits only, and place the vertex anywhere.
TEST_F(MisreadFiles, NumbersOfManyDigitsAreReadWhole) {
  const std::string why = "reaches 1e+23 m from its origin";
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

TEST_F(MisreadFiles, ManyDecimalDigitsAreRead) {
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

// ---- Words of a file in what is said of it ----

TEST_F(MisreadFiles, MessagesArePlainText) {
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
               Zip({{"3D/3dmodel.model",
                     ThreeMfModel("<resources><object id=\"1\" name=\"" + name + "\">" +
                                  ThreeMfBox(1, 1, 1) +
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

}  // namespace
}  // namespace tandem
