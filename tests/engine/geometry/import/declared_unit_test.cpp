#include "engine/geometry/import/declared_unit.h"

#include <optional>
#include <string>
#include <string_view>

#include <gmock/gmock.h>

#include "engine/geometry/formats/package/model_3mf.h"
#include "tests/engine/geometry/import/mesh_file_fixture.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;
using testing::MeshFile;
using testing::ThreeMf;
using testing::WhyNot;

// Boxes of 1 x 1 x 1 (lid, lifted by 5 on a component) and 2 x 2 x 3 (cup), and one of 1 at x = 10.
TEST_F(MeshFile, ReadsAPartOfA3mfFileInTheUnitThatItDeclares) {
  const auto size_of = [this](const std::string& unit, const ImportOptions& options) {
    const Result<TriangleMesh> mesh = ImportMesh(Write("two.3mf", ThreeMf(unit)), options);
    EXPECT_TRUE(mesh) << mesh.error().what;
    return mesh ? BoundsOf(*mesh) : Bounds{};
  };
  const ImportOptions declared{.scale = std::nullopt};
  // the whole: from the cup's corner to that of the third box
  EXPECT_NEAR(size_of("unit=\"inch\"", declared).size().x(), 11 * 0.0254, 1e-9);
  EXPECT_NEAR(size_of("unit=\"millimeter\"", declared).size().x(), 11e-3, 1e-9);
  EXPECT_NEAR(size_of("", declared).size().x(), 11e-3, 1e-9);  // the format's default
  EXPECT_NEAR(size_of("unit=\"inch\"", {.scale = 0.01}).size().x(), 0.11, 1e-9);
  EXPECT_NEAR(size_of("unit=\"inch\"", {}).size().x(), 11, 1e-9);

  const Bounds cup = size_of("", {.part = "Object_2"});
  EXPECT_TRUE(cup.min.isApprox(Vec3(0, 0, 0)) && cup.max.isApprox(Vec3(2, 2, 3)));
  const Bounds lid = size_of("", {.part = "Object_1"});  // it stands where the whole has it
  EXPECT_TRUE(lid.min.isApprox(Vec3(0, 0, 5)) && lid.max.isApprox(Vec3(1, 1, 6)));
  const Bounds both = size_of("", {.part = "Object_3"});
  EXPECT_TRUE(both.min.isApprox(Vec3(0, 0, 0)) && both.max.isApprox(Vec3(2, 2, 6)));

  const Result<TriangleMesh> none = ImportMesh(Write("two.3mf", ThreeMf("")), {.part = "Object_9"});
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().what, HasSubstr("it has no part 'Object_9', but lid, cup, Object_4"));
}

TEST_F(MeshFile, Truncated3mfFileIsRefused) {
  const std::string whole = ThreeMf("unit=\"inch\"");
  for (std::size_t size = 0; size < whole.size(); size += 37) {
    EXPECT_EQ(Read3mf(Write("cut.3mf", whole.substr(0, size)), "").kind, ReadAnswer::Kind::kRefused)
        << size;
  }
  EXPECT_EQ(Read3mf(Write("whole.3mf", whole), "").metres_per_unit, 0.0254);
}

// The unit stands in XML's first element, however XML may be written. The format's default is a
// millimetre.
TEST_F(MeshFile, A3mfFilesUnitIsReadHoweverItsXmlIsWritten) {
  const auto read = [this](const std::string& head, const std::string& prefix) {
    std::string model = head;
    for (const char* piece :
         {"<resources>", "<object id=\"1\">", "<mesh>", "<vertices>",
          "<vertex x=\"0\" y=\"0\" z=\"0\"/>", "</vertices>", "</mesh>", "</object>",
          "</resources>", "<build>", "<item objectid=\"1\"/>", "</build>", "</model>"}) {
      const std::string_view words = piece;
      const std::size_t begin = words.starts_with("</") ? 2 : 1;
      model += std::string(words.substr(0, begin)) + prefix + std::string(words.substr(begin));
    }
    return Read3mf(Write("model.3mf", testing::Zip({{"3D/3dmodel.model", model}})), "");
  };
  EXPECT_EQ(read("<m:model unit=\"inch\">", "m:").metres_per_unit, 0.0254);
  for (const char* inch :
       {"<model unit=\"inch\">", "<model\tunit=\"inch\">", "<model\nunit=\"inch\"\n>",
        "<model xml:lang=\"en\" unit = 'inch' >",
        "\xEF\xBB\xBF<?xml version=\"1.0\"?>\n<!-- <model unit=\"meter\"> -->\n<model "
        "unit=\"inch\">",
        "<model note=\" unit='foot' > \" unit=\"inch\">"}) {
    EXPECT_EQ(read(inch, "").metres_per_unit, 0.0254) << inch;
  }
  for (const char* millimetre : {"<model>", "<model xml:lang=\"en\" my_unit=\"inch\">",
                                 "<model units=\"inch\">", "<model\n>"}) {
    EXPECT_EQ(read(millimetre, "").metres_per_unit, 1e-3) << millimetre;
  }
  for (const char* doubtful : {"<model unit=\"inches\">", "<model unit=\"\">"}) {
    EXPECT_EQ(read(doubtful, "").metres_per_unit, 0) << doubtful;
  }
  for (const char* wrong :
       {"<model unit=\"inch", "<model unit=", "<model unit", "<model", "<model unit=inch>",
        "<model unit=\"inch\" unit=\"foot\">", "<models unit=\"inch\">",
        "<!-- <model unit=\"inch\">", "<other/><model unit=\"inch\">",
        "<!DOCTYPE model [<!ENTITY a \"b\">]><model unit=\"inch\">", ""}) {
    EXPECT_EQ(read(wrong, "").kind, ReadAnswer::Kind::kRefused) << wrong;
  }
}

TEST_F(MeshFile, A3mfFileOfAnUnknownUnitNeedsAScale) {
  const auto file = Write("two.3mf", ThreeMf("unit=\"furlong\""));
  EXPECT_THAT(WhyNot(ImportMesh(file, {.scale = std::nullopt})),
              HasSubstr("two.3mf: the unit that it declares cannot be read: give a \"scale\""));
  const Result<TriangleMesh> mesh = ImportMesh(file, {.scale = 0.01});
  ASSERT_TRUE(mesh) << WhyNot(mesh);
  EXPECT_NEAR(BoundsOf(*mesh).size().x(), 0.11, 1e-9);
}

TEST(DeclaredUnit, IsThatOfFourKindsOfFiles) {
  for (const char* kind : {"a.3mf", "a.AMF", "a.dae", "a.fbx"}) EXPECT_TRUE(KindDeclaresUnit(kind));
  for (const char* kind : {"a.stl", "a.obj", "3mf", "a.glb"}) EXPECT_FALSE(KindDeclaresUnit(kind));
}

}  // namespace
}  // namespace tandem
