// Tests 3MF files as slicers write them: parts that are no material, names and prefixes in other
// forms, texts in UTF-16.
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/geometry/import/mesh_file.h"
#include "tests/engine/geometry/formats/misread_files.h"

namespace tandem {
namespace {

using testing::MisreadFiles;
using testing::ThreeMfBox;
using testing::ThreeMfModel;
using testing::With;
using testing::Zip;

/// Returns an object of two components, boxes of 1 x 2 x 3 (2) and 1 x 1 x 1 (3).
std::string TwoBoxes() {
  return ThreeMfModel("<resources><object id=\"2\" type=\"model\">" + ThreeMfBox(1, 2, 3) +
                      "</object><object id=\"3\" type=\"model\">" + ThreeMfBox(1, 1, 1) +
                      "</object><object id=\"1\" type=\"model\"><components><component "
                      "objectid=\"2\"/><component objectid=\"3\"/>"
                      "</components></object></resources><build><item objectid=\"1\"/></build>");
}

class SlicerFiles : public MisreadFiles {
 protected:
  /// Expects a volume, and one remark that contains these words; none where it is empty.
  void ExpectTold(double volume, const std::string& words, const std::string& content) {
    std::vector<std::string> remarks;
    const Result<TriangleMesh> mesh = ImportMesh(folder_.Write("part.3mf", content), {}, &remarks);
    ASSERT_TRUE(mesh) << mesh.error().what;
    EXPECT_NEAR(ComputeMassProperties(*mesh).volume, volume, 1e-6 * volume);
    std::erase_if(remarks, [](const std::string& remark) {
      return remark.find("m per unit") != std::string::npos;  // these files are read in metres
    });
    if (words.empty()) {
      EXPECT_THAT(remarks, ::testing::IsEmpty());
    } else {
      EXPECT_THAT(remarks, ::testing::ElementsAre(::testing::HasSubstr(words)));
    }
  }
};

const std::string kLeftOut = "1 modifier or support of a slicer left out: they are no material";
const std::string kNegative = "it has a negative part, which takes material away";

// Bambu Studio and Orca name the use of each component.
TEST_F(SlicerFiles, ComponentsThatAreNoMaterialAreLeftOutOrRefused) {
  const auto file = [](const std::string& subtype) {
    return Zip({{"3D/3dmodel.model", TwoBoxes()},
                {"Metadata/model_settings.config",
                 "<?xml version=\"1.0\"?><config><object id=\"1\"><part id=\"2\" "
                 "subtype=\"normal_part\"/><part id=\"3\" subtype=\"" +
                     subtype + "\"/></object></config>"}});
  };
  ExpectTold(7, "", file("normal_part"));
  for (const char* subtype : {"modifier_part", "support_blocker", "support_enforcer"}) {
    ExpectTold(6, kLeftOut, file(subtype));
  }
  ExpectRefused(kNegative, "part.3mf", file("negative_part"));
}

// PrusaSlicer and Slic3r name the use of ranges of triangles.
TEST_F(SlicerFiles, RangesThatAreNoMaterialAreLeftOutOrRefused) {
  // the boxes' triangles in one object: 24 corners, 8 of each
  std::string low = ThreeMfBox(1, 2, 3);
  const std::string high = ThreeMfBox(1, 1, 1);
  const auto between = [](const std::string& text, const std::string& begin,
                          const std::string& end) {
    const std::size_t at = text.find(begin) + begin.size();
    return text.substr(at, text.find(end) - at);
  };
  std::string moved = between(high, "<triangles>", "</triangles>");
  for (int corner = 7; corner >= 0; --corner) {
    const std::string old = "=\"" + std::to_string(corner) + "\"";
    for (std::size_t at = moved.find(old); at != std::string::npos; at = moved.find(old, at + 1)) {
      moved.replace(at, old.size(), "=\"" + std::to_string(corner + 8) + "\"");
    }
  }
  low = With(low, "</vertices>", between(high, "<vertices>", "</vertices>") + "</vertices>");
  low = With(low, "</triangles>", moved + "</triangles>");
  const auto file = [&](const std::string& config, const std::string& settings) {
    return Zip({{"3D/3dmodel.model",
                 ThreeMfModel("<resources><object id=\"1\" type=\"model\">" + low +
                              "</object></resources><build><item objectid=\"1\"/></build>")},
                {config,
                 "<?xml version=\"1.0\"?><config><object id=\"1\"><volume firstid=\"0\" "
                 "lastid=\"11\"><metadata type=\"volume\" key=\"volume_type\" "
                 "value=\"ModelPart\"/></volume>"
                 "<volume firstid=\"12\" lastid=\"23\"><metadata type=\"volume\" " +
                     settings + "/></volume></object></config>"}});
  };
  const std::string prusa = "Metadata/Slic3r_PE_model.config";
  ExpectTold(7, "", file(prusa, "key=\"volume_type\" value=\"ModelPart\""));
  ExpectTold(6, kLeftOut, file(prusa, "key=\"volume_type\" value=\"ParameterModifier\""));
  ExpectTold(6, kLeftOut, file(prusa, "key=\"volume_type\" value=\"SupportBlocker\""));
  ExpectTold(6, kLeftOut, file("Metadata/Slic3r_model.config", "key=\"modifier\" value=\"1\""));
  ExpectRefused(kNegative, "part.3mf", file(prusa, "key=\"volume_type\" value=\"NegativeVolume\""));
}

TEST_F(SlicerFiles, DamagedSettingsAreRefused) {
  const std::string settings =
      "<?xml version=\"1.0\"?><config><object id=\"1\"><part id=\"3\" "
      "subtype=\"modifier_part\"/></object></config>";
  const auto file = [](const std::string& config) {
    return Zip({{"3D/3dmodel.model", TwoBoxes()}, {"Metadata/model_settings.config", config}});
  };
  ExpectTold(6, kLeftOut, file(settings));
  const std::string why = "its settings Metadata/model_settings.config ";
  ExpectRefused(why + "cannot be read: they are damaged", "part.3mf",
                file(settings.substr(0, settings.size() - 20)));
  // a byte of the archive is another, not of what was packed
  ExpectRefused(why + "is damaged", "part.3mf",
                With(file(settings), "modifier_part", "nodifier_part"));
  ExpectRefused(why + "cannot be read", "part.3mf",
                file("<config><object id=\"1\"><volume firstid=\"0\" lastid=\"x\"><metadata "
                     "key=\"volume_type\" value=\"NegativeVolume\"/></volume></object></config>"));
}

// Settings name the objects of the first model. In Bambu Studio's files, others have the same
// numbers in models of their own.
TEST_F(SlicerFiles, SettingsDoNotMeanObjectsOfOtherModels) {
  const std::string other = ThreeMfModel("<resources><object id=\"1\" type=\"model\">" +
                                         ThreeMfBox(1, 1, 1) + "</object></resources><build/>");
  const std::string root = ThreeMfModel(
      "<resources><object id=\"1\" type=\"model\">" + ThreeMfBox(1, 2, 3) +
      "</object></resources><build><item objectid=\"1\" p:path=\"/3d/3DMODEL.model\"/><item "
      "objectid=\"1\" p:path=\"/3D/other.model\"/></build>");
  // none of the first model's triangles is material
  const std::string settings =
      "<config><object id=\"1\"><volume firstid=\"0\" lastid=\"11\"><metadata "
      "key=\"volume_type\" value=\"SupportBlocker\"/></volume></object></config>";
  ExpectTold(1, kLeftOut,
             Zip({{"3D/3dmodel.model", root},
                  {"3D/other.model", other},
                  {"Metadata/Slic3r_PE_model.config", settings}}));
}

TEST_F(SlicerFiles, SameNumberTwiceIsRefused) {
  ExpectRefused("has several objects of the number 2", "part.3mf",
                Zip({{"3D/3dmodel.model", With(TwoBoxes(), "id=\"3\" type", "id=\"2\" type")}}));
}

TEST_F(SlicerFiles, BlanksRoundNumbersAreSkippedAndMoreNumbersRefused) {
  ExpectTold(7, "", Zip({{"3D/3dmodel.model", With(TwoBoxes(), "x=\"1\"", "x=\" 1 \"")}}));
  const auto placed = [](const std::string& transform) {
    return Zip(
        {{"3D/3dmodel.model", With(TwoBoxes(), "<item objectid=\"1\"",
                                   "<item objectid=\"1\" transform=\"" + transform + "\"")}});
  };
  ExpectTold(7, "", placed("1 0 0 0 1 0 0 0 1 0 0 5 "));
  ExpectRefused("places an object in a way that is not known", "part.3mf",
                placed("1 0 0 0 0 1 0 0 0 0 1 0 0 0 5 1"));
}

TEST_F(SlicerFiles, SupportsOfTheModelAreLeftOut) {
  ExpectTold(6, kLeftOut,
             Zip({{"3D/3dmodel.model",
                   With(TwoBoxes(), "id=\"3\" type=\"model\"", "id=\"3\" type=\"support\"")}}));
}

TEST_F(SlicerFiles, CurasMeshesOfSettingsAreLeftOut) {
  const std::string mark =
      "<metadatagroup><metadata name=\"cura:infill_mesh\" "
      "type=\"xs:string\">True</metadata></metadatagroup>";
  ExpectTold(6, kLeftOut,
             Zip({{"3D/3dmodel.model", With(TwoBoxes(), "id=\"3\" type=\"model\">",
                                            "id=\"3\" type=\"model\">" + mark)}}));
}

TEST_F(SlicerFiles, NamesThatDifferInCaseAreTheSame) {
  const std::string relations =
      "<?xml version=\"1.0\"?><Relationships "
      "xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">"
      "<Relationship Target=\"/3d/3DModel.model\" Id=\"r\" "
      "Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>";
  ExpectTold(7, "", Zip({{"_rels/.rels", relations}, {"3D/3dmodel.model", TwoBoxes()}}));
  ExpectTold(7, "", Zip({{"_Rels/.RELS", relations}, {"3D\\3dmodel.model", TwoBoxes()}}));
  ExpectTold(7, "", Zip({{"/3D/3DMODEL.MODEL", TwoBoxes()}}));
}

TEST_F(SlicerFiles, PrefixesOfTheFormatAreItsOwn) {
  std::string prefixed;
  const std::string text = TwoBoxes();
  for (std::size_t at = 0; at < text.size(); ++at) {
    prefixed += text[at];
    if (text[at] != '<' || text[at + 1] == '?') continue;
    if (text[at + 1] == '/') prefixed += text[++at];
    prefixed += "m:";
  }
  prefixed = With(prefixed, "xmlns=", "xmlns:m=");
  ExpectTold(7, "", Zip({{"3D/3dmodel.model", prefixed}}));
  // an element of that name in another's space is none of the format's
  const std::string other =
      "<x:triangles xmlns:x=\"urn:x\"><x:triangle v1=\"0\" v2=\"1\" "
      "v3=\"99\"/></x:triangles></mesh>";
  ExpectTold(7, "", Zip({{"3D/3dmodel.model", With(TwoBoxes(), "</mesh>", other)}}));
}

TEST_F(SlicerFiles, ModelsInUtf16AreRead) {
  for (const bool big : {false, true}) {
    std::string wide = big ? "\xFE\xFF" : "\xFF\xFE";
    for (const char c : TwoBoxes()) {
      if (big) wide += '\0';
      wide += c;
      if (!big) wide += '\0';
    }
    ExpectTold(7, "", Zip({{"3D/3dmodel.model", wide}}));
  }
}

TEST_F(SlicerFiles, ExtensionsThatAreUsedAndNotRequiredAreTold) {
  const std::string beams =
      "<b:beamlattice "
      "xmlns:b=\"http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02\"/></mesh>";
  ExpectTold(7, "1 beam lattice left out",
             Zip({{"3D/3dmodel.model", With(TwoBoxes(), "</mesh>", beams)}}));
}

TEST_F(SlicerFiles, ObjectsThatNothingPlacesAreRefused) {
  ExpectRefused("its build places none of its objects", "part.3mf",
                Zip({{"3D/3dmodel.model", With(TwoBoxes(), "<item objectid=\"1\"/>", "")}}));
}

TEST_F(SlicerFiles, WordsBehindANumberAreRefused) {
  for (const std::string word : {"1mm", "1,0", "1.0-1"}) {
    ExpectRefused("has a vertex without its three numbers", "part.3mf",
                  Zip({{"3D/3dmodel.model", With(TwoBoxes(), "x=\"1\"", "x=\"" + word + "\"")}}));
  }
}

}  // namespace
}  // namespace tandem
