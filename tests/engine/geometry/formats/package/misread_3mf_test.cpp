// Tests 3MF files of several models, and archives that are not whole.
#include <string>

#include <gtest/gtest.h>

#include "tests/engine/geometry/formats/misread_files.h"

namespace tandem {
namespace {

using testing::MisreadFiles;
using testing::ThreeMfBox;
using testing::ThreeMfModel;
using testing::With;
using testing::Zip;

/// Returns a box of 1 x 2 x 3 in a model of its own, put twice into the first model's object, once
/// mirrored.
std::string SeveralModels(const std::string& unit_of_part = "millimeter") {
  return Zip(
      {{"3D/parts/box.model",
        ThreeMfModel("<resources><object id=\"7\" type=\"model\" name=\"box\">" +
                         ThreeMfBox(1, 2, 3) + "</object></resources><build/>",
                     unit_of_part)},
       {"3D/3dmodel.model",
        ThreeMfModel(
            "<resources><object id=\"1\" type=\"model\"><components>"
            "<component p:path=\"/3D/parts/box.model\" objectid=\"7\"/>"
            "<component p:path=\"/3D/parts/box.model\" objectid=\"7\" "
            "transform=\"-1 0 0 0 1 0 0 0 1 10 0 0\"/></components></object></resources>"
            "<build><item objectid=\"1\" transform=\"2 0 0 0 2 0 0 0 2 0 0 5\"/></build>")}});
}

TEST_F(MisreadFiles, A3mfFileOfSeveralModelsIsCombined) {
  ExpectVolume(2 * 6 * 8, "two.3mf", SeveralModels());
  ExpectVolume(2 * 6 * 8e-9, "two.3mf", SeveralModels(), {.scale = std::nullopt});
  ExpectVolume(2 * 6 * 8, "two.3mf", SeveralModels(), {.part = "box"});
  const Result<TriangleMesh> mesh = Read("two.3mf", SeveralModels());
  Bounds bounds = BoundsOf(*mesh);
  EXPECT_TRUE(bounds.min.isApprox(Vec3(0, 0, 5)) && bounds.max.isApprox(Vec3(20, 4, 11)));
  ExpectRefused("it has no part 'lid', but", "two.3mf", SeveralModels(), {.part = "lid"});
}

TEST_F(MisreadFiles, Invalid3mfFileOfSeveralModelsIsRefusedWithAReason) {
  ExpectRefused("several units, millimeter and inch", "unit.3mf", SeveralModels("inch"));
  const std::string circle = ThreeMfModel(
      "<resources><object id=\"1\"><components><component objectid=\"1\" "
      "p:path=\"/3D/3dmodel.model\"/></components></object></resources>"
      "<build><item objectid=\"1\"/></build>");
  ExpectRefused("within one another", "circle.3mf", Zip({{"3D/3dmodel.model", circle}}));
  const std::string missing =
      ThreeMfModel("<resources/><build><item objectid=\"1\" p:path=\"/3D/none.model\"/></build>");
  ExpectRefused("3D/none.model is missing", "none.3mf", Zip({{"3D/3dmodel.model", missing}}));
}

// The triangles in such a file may be a sketch only, or other things count in their place. Both
// files hold 14: boxes of 1, 1 and 12, or one of 1 x 2 x 7.
TEST_F(MisreadFiles, A3mfFileWithRequiredExtensionsIsRefused) {
  const std::string begin = "http://schemas.microsoft.com/3dmanufacturing/";
  const auto needs = [&](const std::string& prefixes, const std::string& space, bool several) {
    const std::string x = "xmlns:x=\"" + begin + space + "\"";
    if (!several) {
      return testing::ThreeMf(x + " xmlns:p=\"" + begin +
                              "production/2015/06\" requiredextensions=\"" + prefixes + "\"");
    }
    return Zip({{"3D/3dmodel.model",
                 ThreeMfModel("<resources><object id=\"1\" type=\"model\">" + ThreeMfBox(1, 2, 7) +
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
      Zip({{"3D/part.model", ThreeMfModel("<resources/><build/>", "millimeter", "x",
                                          "xmlns:x=\"" + begin + "slice/2015/07\"")},
           {"3D/3dmodel.model",
            ThreeMfModel(
                "<resources/><build><item objectid=\"1\" p:path=\"/3D/part.model\"/></build>")}});
  ExpectRefused("its model 3D/part.model needs the extension", "part.3mf", part);
}

// A box of 2 x 2 x 3 has a width of 7 by one changed byte. The archive says what its bytes add up
// to.
TEST_F(MisreadFiles, A3mfFileWithAWrongChecksumIsRefused) {
  ExpectRefused("its model 3D/3dmodel.model is damaged", "flip.3mf",
                With(testing::ThreeMf("unit=\"millimeter\""), "x=\"2\" y=\"2\" z=\"3\"",
                     "x=\"7\" y=\"2\" z=\"3\""));
  ExpectRefused("its model 3D/parts/box.model is damaged", "flip.3mf",
                With(SeveralModels(), "x=\"1\" y=\"2\" z=\"3\"", "x=\"7\" y=\"2\" z=\"3\""));
}

TEST_F(MisreadFiles, Truncated3mfFileIsRefused) {
  std::string cut = SeveralModels();
  const std::size_t entry = cut.find("PK\x01\x02");
  ASSERT_NE(entry, std::string::npos);
  // it ends where its last triangle would begin
  const std::size_t size = cut.rfind("<triangle ", cut.find("</triangles>")) - cut.find("<?xml");
  cut.replace(entry + 20, 4, testing::Bytes(size, 4));
  ExpectRefused("its model 3D/parts/box.model is damaged", "cut.3mf", cut);
}

TEST_F(MisreadFiles, A3mfFilesUnitIsThatOfItsRootModel) {
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

}  // namespace
}  // namespace tandem
