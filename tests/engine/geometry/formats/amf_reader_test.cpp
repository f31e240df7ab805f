// Tests what AMF files say of units, places and uses of parts. All meshes are made of a tetrahedron
// of volume 1/6.
#include <string>

#include <gtest/gtest.h>

#include "engine/geometry/formats/native_readers.h"
#include "tests/engine/geometry/formats/misread_files.h"
#include "tests/engine/geometry/formats/read_answers.h"

namespace tandem {
namespace {

using testing::ExpectNot;
using testing::ExpectRead;
using testing::ExpectReadWith;
using testing::kTetra;
using testing::MisreadFiles;
using testing::With;

std::string AmfVertex(const std::string& x, const std::string& y, const std::string& z) {
  return "<vertex><coordinates><x>" + x + "</x><y>" + y + "</y><z>" + z +
         "</z></coordinates></vertex>";
}

const std::string kAmfVertices = "<vertices>" + AmfVertex("0", "0", "0") +
                                 AmfVertex("1", "0", "0") + AmfVertex("0", "1", "0") +
                                 AmfVertex("0", "0", "1") + "</vertices>";

std::string AmfTriangles() {
  std::string text;
  for (const char* corners : {"021", "013", "123", "032"}) {
    text += "<triangle>";
    for (int k = 0; k < 3; ++k) {
      const std::string v = "v" + std::to_string(k + 1);
      text += "<" + v + "> " + corners[k] + " </" + v + ">";
    }
    text += "</triangle>";
  }
  return text;
}

std::string AmfObject(const std::string& id, const std::string& name, const std::string& volumes) {
  return "<object id=\"" + id + "\"><metadata type=\"name\">" + name + "</metadata><mesh>" +
         kAmfVertices + volumes + "</mesh></object>";
}

std::string AmfVolume(const std::string& words = "") {
  return "<volume>" + words + AmfTriangles() + "</volume>";
}

std::string Amf(const std::string& inside, const std::string& unit = "unit=\"millimeter\"") {
  return "<?xml version=\"1.0\"?><amf " + unit + " version=\"1.1\">" + inside + "</amf>";
}

TEST(AmfReader, UnitIsDeclared) {
  const auto unit = [](const std::string& words) {
    const ReadAnswer answer = ReadAmf(Amf(AmfObject("1", "a", AmfVolume()), words));
    ExpectRead(kTetra, answer);
    return answer.metres_per_unit;
  };
  EXPECT_EQ(unit("unit=\"inch\""), 0.0254);
  EXPECT_EQ(unit("unit=\"meter\""), 1);
  EXPECT_EQ(unit("unit=\"Feet\""), 0.3048);
  EXPECT_EQ(unit("unit=\"micron\""), 1e-6);
  EXPECT_EQ(unit(""), 1e-3);  // the format's default
  EXPECT_EQ(unit("unit=\"furlong\""), 0);
}

TEST_F(MisreadFiles, AmfIsReadInTheUnitThatItDeclares) {
  const std::string inches = Amf(AmfObject("1", "a", AmfVolume()), "unit=\"inch\"");
  ExpectVolume(kTetra * 0.0254 * 0.0254 * 0.0254, "a.amf", inches, {.scale = std::nullopt});
  ExpectVolume(kTetra, "a.amf", testing::Zip({{"a.amf", inches}}));
  ExpectRefused("the unit that it declares cannot be read", "a.amf",
                With(inches, "inch", "furlong"), {.scale = std::nullopt});
}

TEST(AmfReader, ConstellationsPlaceObjects) {
  const auto placed = [](const std::string& instance) {
    return ReadAmf(Amf(AmfObject("1", "a", AmfVolume()) + AmfObject("2", "b", AmfVolume()) +
                       "<constellation id=\"3\">" + instance + "</constellation>"));
  };
  const ReadAnswer two = placed(
      "<instance objectid=\"1\"><deltax>5</deltax><rz>90</rz></instance><instance "
      "objectid=\"2\"><deltaz>-1</deltaz></instance>");
  ExpectRead(2 * kTetra, two);
  EXPECT_EQ(two.mesh.points[1], (FilePoint{5, 1, 0}));  // x is turned to y
  EXPECT_EQ(two.mesh.points[7], (FilePoint{0, 0, 0}));
  // rx before ry before rz: z is turned to -y, then stays, then to x
  const ReadAnswer turned = placed("<instance objectid=\"1\"><rx>90</rx><rz>90</rz></instance>");
  EXPECT_EQ(turned.mesh.points[3], (FilePoint{1, 0, 0}));
  ExpectReadWith(kTetra, "1 object that no constellation places left out", turned);
  ExpectNot("there is no object 9", placed("<instance objectid=\"9\"/>"));
  ExpectNot("within one another",
            ReadAmf(Amf(AmfObject("1", "a", AmfVolume()) +
                        "<constellation id=\"3\"><instance objectid=\"3\"/></constellation>")));
}

TEST(AmfReader, PartsThatAreNoMaterialAreLeftOutOrRefused) {
  const auto with = [](const std::string& volume) {
    return ReadAmf(Amf(AmfObject("1", "a", AmfVolume() + volume)));
  };
  ExpectRead(2 * kTetra, with(AmfVolume()));
  const std::string told = "1 modifier or support of a slicer left out: they are no material";
  ExpectReadWith(kTetra, told, with(AmfVolume("<metadata type=\"slic3r.modifier\">1</metadata>")));
  ExpectReadWith(
      kTetra, told,
      with(AmfVolume("<metadata type=\"slic3r.volume_type\">ParameterModifier</metadata>")));
  ExpectReadWith(kTetra, told, with("<volume type=\"support\">" + AmfTriangles() + "</volume>"));
  ExpectRead(2 * kTetra,
             with(AmfVolume("<metadata type=\"slic3r.volume_type\">ModelPart</metadata>")));
  ExpectNot("it has a negative part, which takes material away",
            with(AmfVolume("<metadata type=\"slic3r.volume_type\">NegativeVolume</metadata>")));
}

TEST(AmfReader, WordsBehindANumberAreRefused) {
  const std::string good = Amf(AmfObject("1", "a", AmfVolume()));
  for (const std::string word : {"1mm", "1,0", "1.0-1", "one"}) {
    ExpectNot("'" + word + "' is not a number",
              ReadAmf(With(good, "<x>1</x>", "<x>" + word + "</x>")));
  }
  ExpectNot("a vertex has not its three numbers", ReadAmf(With(good, "<x>1</x>", "")));
  ExpectNot("uses vertex 7, but there are only 4", ReadAmf(With(good, "> 3 <", "> 7 <")));
  ExpectNot("it is not whole", ReadAmf(good.substr(0, good.size() / 2) + "<"));
}

TEST(AmfReader, FileThatEndsEarlyIsRefused) {
  const std::string good = Amf(AmfObject("1", "a", AmfVolume()));
  for (std::size_t size = 0; size + 1 < good.size(); size += 13) {
    EXPECT_EQ(ReadAmf(good.substr(0, size)).kind, ReadAnswer::Kind::kRefused) << size;
  }
}

TEST(AmfReader, CurvedTrianglesAreTold) {
  const std::string edge = "<edge><v1>0</v1><dx1>1</dx1></edge></vertices>";
  ExpectReadWith(kTetra, "its curved triangles are read as flat ones",
                 ReadAmf(With(Amf(AmfObject("1", "a", AmfVolume())), "</vertices>", edge)));
}

TEST(AmfReader, PartsAreObjectsByNameAndNumber) {
  const std::string two =
      Amf(AmfObject("1", "low", AmfVolume()) + AmfObject("2", "high", AmfVolume() + AmfVolume()));
  ExpectRead(2 * kTetra, ReadAmf(two, "high"));
  ExpectRead(kTetra, ReadAmf(two, "Object_1"));
  ExpectNot("it has no part 'lid', but low, high", ReadAmf(two, "lid"));
}

}  // namespace
}  // namespace tandem
