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

// Slic3r and its descendants number constellations without regard to objects.
TEST(AmfReader, IdThatNamesAnObjectPlacesTheObject) {
  const std::string two = AmfObject("0", "a", AmfVolume()) + AmfObject("1", "b", AmfVolume());
  const auto placed = [&](const std::string& id, const std::string& instances) {
    return ReadAmf(Amf(two + "<constellation" + id + ">" + instances + "</constellation>"));
  };
  const std::string both = "<instance objectid=\"0\"/><instance objectid=\"1\"/>";
  ExpectRead(2 * kTetra, placed(" id=\"1\"", both));
  ExpectRead(2 * kTetra, placed(" id=\"0\"", both));
  ExpectRead(2 * kTetra, placed(" id=\"\"", both));
  ExpectRead(2 * kTetra, placed("", both));
  // an id that no object has is that of a constellation
  ExpectRead(3 * kTetra, ReadAmf(Amf(two + "<constellation id=\"1\">" + both +
                                     "<instance objectid=\"5\"/></constellation><constellation "
                                     "id=\"5\"><instance objectid=\"1\"/></constellation>")));
}

TEST(AmfReader, SameIdTwiceIsRefused) {
  ExpectNot("it has several objects of the id 1",
            ReadAmf(Amf(AmfObject("1", "a", AmfVolume()) + AmfObject("1", "b", AmfVolume()))));
  const std::string group = "<constellation id=\"3\"><instance objectid=\"1\"/></constellation>";
  ExpectNot("it has several constellations of the id 3",
            ReadAmf(Amf(AmfObject("1", "a", AmfVolume()) + group + group)));
  // objects without an id are none of the same id
  const std::string bare = "<object><mesh>" + kAmfVertices + AmfVolume() + "</mesh></object>";
  ExpectRead(2 * kTetra, ReadAmf(Amf(bare + bare)));
}

TEST(AmfReader, SizesAndMirrorsOfInstancesAreHonoured) {
  const auto placed = [](const std::string& words) {
    return ReadAmf(Amf(AmfObject("0", "a", AmfVolume()) +
                       "<constellation id=\"1\"><instance objectid=\"0\">" + words +
                       "</instance></constellation>"));
  };
  ExpectRead(8 * kTetra, placed("<scale>2</scale>"));
  ExpectRead(24 * kTetra, placed("<scalex>2</scalex><scaley>3</scaley><scalez>4</scalez>"));
  // a mirror turns the triangles round: the volume stays above 0
  const ReadAnswer mirrored =
      placed("<deltax>5</deltax><scalex>2</scalex><mirrorx>-1</mirrorx><mirrory>1</mirrory>");
  ExpectRead(2 * kTetra, mirrored);
  EXPECT_EQ(mirrored.mesh.points[1], (FilePoint{3, 0, 0}));
}

TEST(AmfReader, AnglesOfSlic3rsLineAreRadians) {
  const std::string told = "its angles are taken as radians";
  const auto placed = [](const std::string& program, const std::string& words) {
    return ReadAmf(Amf("<metadata type=\"cad\">" + program + "</metadata>" +
                       AmfObject("0", "a", AmfVolume()) +
                       "<constellation id=\"1\"><instance objectid=\"0\">" + words +
                       "</instance></constellation>"));
  };
  for (const char* program : {"Slic3r 1.3.0", "PrusaSlicer 2.3.0+x64", "SuperSlicer 2.3"}) {
    const ReadAnswer quarter = placed(program, "<deltay>7</deltay><rz>1.570796</rz>");
    ExpectReadWith(kTetra, told, quarter);
    EXPECT_EQ(quarter.mesh.points[1], (FilePoint{0, 8, 0}));
    ExpectRead(kTetra, placed(program, "<rz>0</rz>"));
  }
  // sizes are of these programs only, whose name may be missing
  const ReadAnswer doubled = placed("another", "<rz>1.5708</rz><scalex>2</scalex>");
  ExpectReadWith(2 * kTetra, told, doubled);
  EXPECT_EQ(doubled.mesh.points[1], (FilePoint{0, 2, 0}));
  // those of any other program are degrees
  const ReadAnswer degrees = placed("another", "<rz>90</rz>");
  ExpectRead(kTetra, degrees);
  EXPECT_EQ(degrees.mesh.points[1], (FilePoint{0, 1, 0}));
}

TEST(AmfReader, WhatInstancesSayBesidesIsTold) {
  const auto placed = [](const std::string& words) {
    return ReadAmf(Amf(AmfObject("0", "a", AmfVolume()) +
                       "<constellation id=\"1\"><instance objectid=\"0\">" + words +
                       "</instance></constellation>"));
  };
  ExpectRead(kTetra, placed("<printable>1</printable>"));
  ExpectReadWith(kTetra, "1 object that is not to be printed read like the others",
                 placed("<printable>0</printable>"));
  ExpectReadWith(kTetra, "2 unknown elements of instances left out, the first is <shear>",
                 placed("<shear>1</shear><skew>1</skew>"));
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
