// Tests what a user is told of a mesh file: units, coordinates far from the origin, formats that
// are read by the mesh library.
#include <cmath>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "engine/base/files/regular_file.h"
#include "engine/geometry/import/kept_mesh.h"
#include "engine/geometry/import/mesh_file.h"
#include "tests/engine/geometry/formats/misread_files.h"

namespace tandem {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::kObjCube;
using testing::With;

class ToldFiles : public testing::MisreadFiles {
 protected:
  struct Told {
    TriangleMesh mesh;
    std::vector<std::string> remarks;
  };
  Told Tell(const std::string& name, const std::string& content,
            const ImportOptions& options = {}) {
    Told told;
    Result<TriangleMesh> mesh = ImportMesh(folder_.Write(name, content), options, &told.remarks);
    EXPECT_TRUE(mesh) << mesh.error().what;
    if (mesh) told.mesh = *std::move(mesh);
    return told;
  }
};

TEST_F(ToldFiles, ScaleTakesThePlaceOfADeclaredUnitAndSaysSo) {
  const std::string inches = testing::ThreeMf("unit=\"inch\"");
  const std::string words =
      "it declares 0.0254 m per unit, and the scale of 0.01 m per unit is taken in its place";
  EXPECT_THAT(Tell("a.3mf", inches, {.scale = 0.01}).remarks, ElementsAre(HasSubstr(words)));
  EXPECT_THAT(Tell("a.3mf", inches, {.scale = std::nullopt}).remarks, IsEmpty());
  EXPECT_THAT(Tell("a.3mf", inches, {.scale = 0.0254}).remarks, IsEmpty());
  EXPECT_THAT(Tell("a.obj", kObjCube, {.scale = 0.01}).remarks, IsEmpty());
  // COLLADA: 0.01 declared and 0.01 given is 0.01, and not a ten-thousandth
  const std::string cm = With(testing::kDaeTriangle, "name=\"meter\" meter=\"1\"",
                              "name=\"centimeter\" meter=\"0.01\"");
  for (const std::optional<double> scale : {std::optional<double>(), std::optional(0.01)}) {
    const Told told = Tell("cm.dae", cm, {.scale = scale});
    EXPECT_THAT(told.remarks, IsEmpty());
    EXPECT_NEAR(BoundsOf(told.mesh).size().y(), 0.02, 1e-9);
  }
  const Told metres = Tell("cm.dae", cm, {.scale = 1});
  EXPECT_NEAR(BoundsOf(metres.mesh).size().y(), 2, 1e-9);
  EXPECT_THAT(metres.remarks, ElementsAre(HasSubstr("it declares 0.01 m per unit")));
}

// Nothing is declared where a file names no unit.
TEST_F(ToldFiles, ScaleBesideAFormatsOwnUnitIsTold) {
  const std::string none = With(testing::kDaeTriangle, "<unit name=\"meter\" meter=\"1\"/>", "");
  EXPECT_THAT(Tell("a.dae", none, {.scale = 0.01}).remarks,
              ElementsAre(HasSubstr("its format has 1 m per unit where a file names no other, and "
                                    "the scale of 0.01 m per unit is taken in its place")));
  EXPECT_THAT(Tell("a.dae", none, {.scale = std::nullopt}).remarks, IsEmpty());
  EXPECT_THAT(Tell("a.3mf", testing::ThreeMf(""), {.scale = 0.01}).remarks,
              ElementsAre(HasSubstr("its format has 0.001 m per unit")));
}

// The library multiplies the unit in; a reader that multiplies it again makes a part a hundredth.
TEST_F(ToldFiles, UnitOfColladasFirstVersionsIsTakenOnce) {
  const std::string old =
      With(With(testing::kDaeTriangle, "version=\"1.4.1\"", "version=\"1.3.1\""), "meter=\"1\"",
           "meter=\"0.01\"");
  const Told told = Tell("old.dae", old, {.scale = std::nullopt});
  EXPECT_NEAR(BoundsOf(told.mesh).size().y(), 0.02, 1e-9);
  EXPECT_THAT(told.remarks, ::testing::Contains(HasSubstr("its unit is multiplied in")));
}

TEST_F(ToldFiles, UnitOfARemarkIsToldAndNotTaken) {
  const std::string inches = "# units: inch\n" + kObjCube;
  const Told told = Tell("a.obj", inches, {.scale = std::nullopt});
  EXPECT_THAT(told.remarks, ElementsAre(HasSubstr("a remark in it says 0.0254 m per unit, and it "
                                                  "is read in metres: give a scale of 0.0254")));
  EXPECT_NEAR(BoundsOf(told.mesh).size().x(), 1, 1e-9);
  EXPECT_THAT(Tell("a.obj", inches, {.scale = 0.0254}).remarks, IsEmpty());
}

// A part of 0.2 m in map coordinates: single precision has steps of half a metre there.
TEST_F(ToldFiles, MapCoordinatesKeepTheShapeOrAreTold) {
  std::string far;
  for (int i = 0; i < 8; ++i) {
    char line[100];
    std::snprintf(line, sizeof line, "v %.4f %.4f %.4f\n", 4712345.125 + 0.2 * (i & 1),
                  4712345.125 + 0.2 * (i >> 1 & 1), 0.2 * (i >> 2 & 1));
    far += line;
  }
  far += kObjCube.substr(kObjCube.find('f'));
  const Told told = Tell("map.obj", far);
  EXPECT_THAT(told.remarks, IsEmpty());
  EXPECT_NEAR(ComputeMassProperties(told.mesh).volume, 0.008, 1e-6);
  EXPECT_NEAR(BoundsOf(told.mesh).min.x(), 4712345.125, 1e-6);

  // the same in 32-bit numbers has steps of 0.5: of the corners 8 m apart, some move
  std::string binary = testing::BinaryStlCube();
  for (std::size_t t = 0; t < 12; ++t) {
    for (std::size_t n = 3; n < 12; ++n) {
      float x = 0;
      std::memcpy(&x, binary.data() + 84 + 50 * t + 4 * n, 4);
      x = 8 * x + 4712345.F;
      std::memcpy(binary.data() + 84 + 50 * t + 4 * n, &x, 4);
    }
  }
  EXPECT_THAT(
      Tell("map.stl", binary).remarks,
      ElementsAre(HasSubstr("it stands so far from its origin that its 32-bit numbers are")));
}

TEST_F(ToldFiles, RemarksStayWithAMeshOfTheCache) {
  const auto file = folder_.Write("a.obj", kObjCube + "l 1 2\n");
  const Result<ImportedMesh> read = ImportAndDiagnose(file, {});
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_THAT(read->remarks, ElementsAre(HasSubstr("1 line or point element")));
  const BlockFileSources key{Sha256OfMany({}), Sha256OfMany({})};
  const auto kept = folder_.path() / "kept";
  ASSERT_FALSE(KeepMesh(*read, key, kept));
  const Result<ImportedMesh> again = LoadKeptMesh(kept, key);
  ASSERT_TRUE(again) << again.error().what;
  EXPECT_EQ(again->remarks, read->remarks);
}

TEST_F(ToldFiles, RemarksAreOnePlainLineEach) {
  for (const std::string& remark :
       Tell("a.obj", kObjCube + "\x1b[31mred\x1b[0m 1 2\n\xE2\x80\xAEl 1 2\n").remarks) {
    EXPECT_TRUE(IsPlainText(remark)) << remark;
  }
}

// ---- Formats of the mesh library ----

std::string Fbx(const std::string& unit) {
  return "; FBX 7.4.0 project file\nFBXHeaderExtension:  {\n\tFBXHeaderVersion: "
         "1003\n\tFBXVersion: "
         "7400\n}\nGlobalSettings:  {\n\tVersion: 1000\n\tProperties70:  {\n" +
         unit +
         "\t}\n}\nDefinitions:  {\n\tVersion: 100\n\tCount: 0\n}\nObjects:  {\n\tGeometry: 100, "
         "\"Geometry::g\", \"Mesh\" {\n\t\tVertices: *12 {\n\t\t\ta: "
         "0,0,0,1,0,0,0,1,0,0,0,1\n\t\t}\n"
         "\t\tPolygonVertexIndex: *12 {\n\t\t\ta: 0,2,-2,0,1,-4,1,2,-4,0,3,-3\n\t\t}\n"
         "\t\tGeometryVersion: 124\n\t}\n\tModel: 200, \"Model::part\", \"Mesh\" {\n\t\tVersion: "
         "232\n"
         "\t}\n}\nConnections:  {\n\tC: \"OO\",200,0\n\tC: \"OO\",100,200\n}\n";
}

TEST_F(ToldFiles, FbxHasTheUnitThatItDeclares) {
  const std::string library =
      "its format is read by a library that leaves out in silence what it does not know";
  const Told inches =
      Tell("a.fbx", Fbx("\t\tP: \"UnitScaleFactor\", \"double\", \"Number\", \"\",2.54\n"),
           {.scale = std::nullopt});
  EXPECT_NEAR(ComputeMassProperties(inches.mesh).volume, std::pow(0.0254, 3) / 6, 1e-12);
  EXPECT_THAT(inches.remarks, ElementsAre(HasSubstr(library)));
  // the format's default is a centimetre
  const Told none = Tell("a.fbx", Fbx(""), {.scale = std::nullopt});
  EXPECT_NEAR(ComputeMassProperties(none.mesh).volume, 1e-6 / 6, 1e-12);
}

}  // namespace
}  // namespace tandem
