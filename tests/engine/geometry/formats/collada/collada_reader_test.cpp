// Tests what COLLADA files say of units, places and shapes. Meshes are squares extruded, or a
// tetrahedron of volume 1/6.
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
using testing::With;

std::string DaeSource(const std::string& id, const std::string& numbers, std::size_t count,
                      std::size_t stride = 3) {
  return "<source id=\"" + id + "\"><float_array id=\"" + id + "-a\" count=\"" +
         std::to_string(count * stride) + "\">" + numbers +
         "</float_array><technique_common><accessor source=\"#" + id + "-a\" count=\"" +
         std::to_string(count) + "\" stride=\"" + std::to_string(stride) +
         "\"/></technique_common></source>";
}

std::string DaeGeometry(const std::string& id, const std::string& points, std::size_t count,
                        const std::string& primitives) {
  return "<geometry id=\"" + id + "\"><mesh>" + DaeSource(id + "-p", points, count) +
         "<vertices id=\"" + id + "-v\"><input semantic=\"POSITION\" source=\"#" + id +
         "-p\"/></vertices>" + primitives + "</mesh></geometry>";
}

const std::string kDaeInput = "<input semantic=\"VERTEX\" source=\"#g-v\" offset=\"0\"/>";
const std::string kDaePoints = "0 0 0 1 0 0 0 1 0 0 0 1";
const std::string kDaeTriangles =
    "<triangles count=\"4\">" + kDaeInput + "<p>0 2 1 0 1 3 1 2 3 0 3 2</p></triangles>";

std::string Collada(const std::string& geometries, const std::string& nodes,
                    const std::string& others = "",
                    const std::string& asset = "<up_axis>Z_UP</up_axis>") {
  return "<?xml version=\"1.0\"?><COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" "
         "version=\"1.4.1\"><asset>" +
         asset + "</asset><library_geometries>" + geometries + "</library_geometries>" + others +
         "<library_visual_scenes><visual_scene id=\"s\">" + nodes +
         "</visual_scene></library_visual_scenes>"
         "<scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>";
}

const std::string kDaeShown = "<instance_geometry url=\"#g\"/>";

ReadAnswer ReadDae(const std::string& text, const std::string& part = "") {
  return *ReadCollada(text, part);
}

std::string DaeTetra(const std::string& in_node, const std::string& others = "",
                     const std::string& asset = "<up_axis>Z_UP</up_axis>") {
  return Collada(DaeGeometry("g", kDaePoints, 4, kDaeTriangles),
                 "<node id=\"n\" name=\"one\">" + in_node + "</node>", others, asset);
}

TEST(ColladaReader, UnitIsDeclaredAndNotMultipliedIn) {
  const auto unit = [](const std::string& words) {
    return ReadDae(DaeTetra(kDaeShown, "", words + "<up_axis>Z_UP</up_axis>"));
  };
  const ReadAnswer centimetres = unit("<unit name=\"centimeter\" meter=\"0.01\"/>");
  ExpectRead(kTetra, centimetres);
  EXPECT_EQ(centimetres.metres_per_unit, 0.01);
  EXPECT_EQ(unit("").metres_per_unit, 1);  // the format's default
  EXPECT_EQ(unit("<unit name=\"inch\" meter=\"0.0254\"/>").metres_per_unit, 0.0254);
  EXPECT_EQ(unit("<unit name=\"inch\" meter=\"-1\"/>").metres_per_unit, 0);
  EXPECT_EQ(unit("<unit name=\"inch\" meter=\"2.5cm\"/>").metres_per_unit, 0);
}

TEST(ColladaReader, UnitByNameIsTakenOrTold) {
  const auto unit = [](const std::string& words) {
    return ReadDae(DaeTetra(kDaeShown, "", words + "<up_axis>Z_UP</up_axis>"));
  };
  const ReadAnswer named = unit("<unit name=\"millimeter\"/>");
  ExpectReadWith(kTetra, "it names its unit 'millimeter' without its metres: the name is taken",
                 named);
  EXPECT_EQ(named.metres_per_unit, 1e-3);
  EXPECT_FALSE(named.unit_of_format);
  const ReadAnswer unknown = unit("<unit name=\"hand\"/>");
  ExpectReadWith(kTetra, "it names a unit 'hand' that is not known", unknown);
  EXPECT_EQ(unknown.metres_per_unit, 1);
  const ReadAnswer other = unit("<unit name=\"inch\" meter=\"1\"/>");
  ExpectReadWith(kTetra, "it names its unit 'inch', and says that it is 1 m: the number is taken",
                 other);
  EXPECT_EQ(other.metres_per_unit, 1);
  ExpectRead(kTetra, unit("<unit name=\"Inch\" meter=\"0.0254\"/>"));
  EXPECT_TRUE(unit("").unit_of_format);
}

TEST(ColladaReader, UnitsOfPartsOfTheFileAreTold) {
  const std::string asset = "<asset><unit name=\"inch\" meter=\"0.0254\"/></asset>";
  const std::string told = "1 unit of a part of the file not honoured";
  ExpectReadWith(kTetra, told, ReadDae(DaeTetra(asset + kDaeShown)));
  ExpectReadWith(
      kTetra, told,
      ReadDae(With(DaeTetra(kDaeShown), "<geometry id=\"g\">", "<geometry id=\"g\">" + asset)));
  ExpectRead(kTetra, ReadDae(DaeTetra("<asset><created>2026</created></asset>" + kDaeShown)));
}

TEST(ColladaReader, AxesAreKeptAndTold) {
  ExpectReadWith(kTetra, "it declares Y_UP: its axes are kept as they are",
                 ReadDae(DaeTetra(kDaeShown, "", "<up_axis>Y_UP</up_axis>")));
}

TEST(ColladaReader, NodesPlaceInTheOrderOfTheirElements) {
  const ReadAnswer placed = ReadDae(DaeTetra(
      "<translate>5 0 0</translate><rotate>0 0 1 90</rotate><scale>2 3 4</scale>" + kDaeShown));
  ExpectRead(24 * kTetra, placed);
  // the corner on x at 2 is turned to y, that on y at 3 to -x
  EXPECT_EQ(placed.mesh.points[1], (FilePoint{5, 2, 0}));
  EXPECT_EQ(placed.mesh.points[2], (FilePoint{2, 0, 0}));
  ExpectRead(6 * kTetra, ReadDae(DaeTetra("<scale>-1 2 3</scale>" + kDaeShown)));
  ExpectRead(8 * kTetra,
             ReadDae(DaeTetra("<matrix>2 0 0 1 0 2 0 1 0 0 2 1 0 0 0 1</matrix>" + kDaeShown)));
  ExpectNot("last row",
            ReadDae(DaeTetra("<matrix>2 0 0 1 0 2 0 1 0 0 2 1 0 0 1 1</matrix>" + kDaeShown)));
  ExpectNot("a <translate> has 2 numbers in place of 3",
            ReadDae(DaeTetra("<translate>5 0</translate>" + kDaeShown)));
  ExpectNot("it has a <skew>, which is not read",
            ReadDae(DaeTetra("<skew>45 0 1 0 1 0 0</skew>" + kDaeShown)));
}

TEST(ColladaReader, InstancesOfNodesAreRead) {
  const std::string library =
      "<library_nodes><node id=\"k\"><scale>2 2 2</scale>" + kDaeShown + "</node></library_nodes>";
  ExpectRead(9 * kTetra, ReadDae(DaeTetra(kDaeShown + "<instance_node url=\"#k\"/>", library)));
  ExpectNot("within one another", ReadDae(DaeTetra("<instance_node url=\"#n\"/>")));
  ExpectNot("it takes 'other.dae#k' from another file",
            ReadDae(DaeTetra("<instance_node url=\"other.dae#k\"/>")));
}

// ---- Primitives ----

/// A tube: a square of 3 with a hole of 1, extruded by 1. Its volume is 8.
std::string DaeTube(const std::string& ends) {
  const std::string points =
      "0 0 0 3 0 0 3 3 0 0 3 0 1 1 0 2 1 0 2 2 0 1 2 0 "
      "0 0 1 3 0 1 3 3 1 0 3 1 1 1 1 2 1 1 2 2 1 1 2 1";
  const std::string sides =
      "<polylist count=\"8\">" + kDaeInput +
      "<vcount>4 4 4 4 4 4 4 4</vcount><p>0 1 9 8 1 2 10 9 2 3 11 10 3 0 8 11 "
      "5 4 12 13 6 5 13 14 7 6 14 15 4 7 15 12</p></polylist>";
  return Collada(DaeGeometry("g", points, 16, sides + ends), "<node>" + kDaeShown + "</node>");
}

TEST(ColladaReader, PolygonsKeepTheirHoles) {
  ExpectRead(8, ReadDae(DaeTube("<polygons count=\"2\">" + kDaeInput +
                                "<ph><p>3 2 1 0</p><h>4 5 6 7</h></ph><ph><p>8 9 10 11</p><h>15 14 "
                                "13 12</h></ph></polygons>")));
  // the turn of a hole does not count
  ExpectRead(8, ReadDae(DaeTube("<polygons count=\"2\">" + kDaeInput +
                                "<ph><p>3 2 1 0</p><h>7 6 5 4</h></ph><ph><p>8 9 10 11</p><h>12 13 "
                                "14 15</h></ph></polygons>")));
  ExpectNot("hole", ReadDae(DaeTube("<polygons count=\"1\">" + kDaeInput +
                                    "<ph><p>4 5 6 7</p><h>0 1 2 3</h></ph></polygons>")));
}

TEST(ColladaReader, PolygonsWithSeveralHolesKeepThemAll) {
  // a bar of 7 x 3 with two holes of 1, extruded by 1: 19
  const std::string low =
      "0 0 0 7 0 0 7 3 0 0 3 0 1 1 0 2 1 0 2 2 0 1 2 0 5 1 0 6 1 0 6 2 0 5 2 0 ";
  const std::string high =
      "0 0 1 7 0 1 7 3 1 0 3 1 1 1 1 2 1 1 2 2 1 1 2 1 5 1 1 6 1 1 6 2 1 5 2 1";
  const std::string prims =
      "<polylist count=\"12\">" + kDaeInput +
      "<vcount>4 4 4 4 4 4 4 4 4 4 4 4</vcount><p>"
      "0 1 13 12 1 2 14 13 2 3 15 14 3 0 12 15 5 4 16 17 6 5 17 18 7 6 18 19 4 7 19 16 "
      "9 8 20 21 10 9 21 22 11 10 22 23 8 11 23 20</p></polylist><polygons count=\"2\">" +
      kDaeInput +
      "<ph><p>3 2 1 0</p><h>4 5 6 7</h><h>8 9 10 11</h></ph>"
      "<ph><p>12 13 14 15</p><h>16 17 18 19</h><h>20 21 22 23</h></ph></polygons>";
  const ReadAnswer bar =
      ReadDae(Collada(DaeGeometry("g", low + high, 24, prims), "<node>" + kDaeShown + "</node>"));
  ExpectRead(19, bar);
}

TEST(ColladaReader, StripsAndFansAreReadWithTheirTurns) {
  const auto shape = [](const std::string& primitives) {
    return ReadDae(
        Collada(DaeGeometry("g", kDaePoints, 4, primitives), "<node>" + kDaeShown + "</node>"));
  };
  ExpectRead(kTetra,
             shape("<tristrips count=\"1\">" + kDaeInput + "<p>0 1 3 2 0 1</p></tristrips>"));
  ExpectRead(kTetra,
             shape("<trifans count=\"2\">" + kDaeInput + "<p>3 0 1 2 0</p><p>0 2 1</p></trifans>"));
  ExpectReadWith(kTetra, "1 primitive of lines without a surface left out",
                 shape(kDaeTriangles + "<lines count=\"1\">" + kDaeInput + "<p>0 1</p></lines>"));
  ExpectReadWith(kTetra, "says that it has 7 triangles, and has 4: these are read",
                 shape(With(kDaeTriangles, "count=\"4\"", "count=\"7\"")));
}

TEST(ColladaReader, CornersHaveOtherNumbersBesideTheirVertex) {
  const std::string mixed =
      "<triangles count=\"4\"><input semantic=\"NORMAL\" source=\"#n\" offset=\"0\"/>"
      "<input semantic=\"VERTEX\" source=\"#g-v\" offset=\"1\"/>"
      "<p>9 0 9 2 9 1 9 0 9 1 9 3 9 1 9 2 9 3 9 0 9 3 9 2</p></triangles>";
  ExpectRead(kTetra, ReadDae(Collada(DaeGeometry("g", kDaePoints, 4, mixed),
                                     "<node>" + kDaeShown + "</node>")));
}

TEST(ColladaReader, CountsThatContradictAreToldOrRefused) {
  const auto shape = [](const std::string& primitives) {
    return ReadDae(
        Collada(DaeGeometry("g", kDaePoints, 4, primitives), "<node>" + kDaeShown + "</node>"));
  };
  const std::string list = "<polylist count=\"4\">" + kDaeInput +
                           "<vcount>3 3 3 3</vcount><p>0 2 1 0 1 3 1 2 3 0 3 2</p></polylist>";
  ExpectRead(kTetra, shape(list));
  ExpectReadWith(kTetra, "a <polylist> says that it has 9 polygons, and has 4: these are read",
                 shape(With(list, "count=\"4\"", "count=\"9\"")));
  ExpectNot("a <polylist> has no <vcount>: it is damaged",
            shape(With(list, "<vcount>3 3 3 3</vcount>", "")));
  ExpectNot("a <polylist> has no <p>: it is damaged",
            shape(With(list, "<p>0 2 1 0 1 3 1 2 3 0 3 2</p>", "")));
  ExpectNot("a <polylist> has no <vcount>",
            shape("<polylist count=\"4\">" + kDaeInput + "</polylist>"));
  ExpectRead(kTetra, shape(kDaeTriangles + "<polylist count=\"0\">" + kDaeInput + "</polylist>"));
  ExpectReadWith(kTetra, "a <tristrips> says that it has 2 strips or fans, and has 1",
                 shape("<tristrips count=\"2\">" + kDaeInput + "<p>0 1 3 2 0 1</p></tristrips>"));
  const std::string polygons = "<polygons count=\"4\">" + kDaeInput +
                               "<p>0 2 1</p><p>0 1 3</p><p>1 2 3</p><p>0 3 2</p></polygons>";
  ExpectRead(kTetra, shape(polygons));
  ExpectReadWith(kTetra, "a <polygons> says that it has 5 polygons, and has 4",
                 shape(With(polygons, "count=\"4\"", "count=\"5\"")));
}

TEST(ColladaReader, PolygonsOfFewerThanThreeCornersAreTold) {
  const std::string list = "<polylist count=\"6\">" + kDaeInput +
                           "<vcount>3 2 3 3 1 3</vcount><p>0 2 1 0 1 0 1 3 1 2 3 2 0 3 2</p>"
                           "</polylist>";
  ExpectReadWith(
      kTetra, "2 polygons with fewer than three corners left out",
      ReadDae(Collada(DaeGeometry("g", kDaePoints, 4, list), "<node>" + kDaeShown + "</node>")));
}

TEST(ColladaReader, ReferencesLeadToElementsOfTheirKind) {
  // a material of the geometry's id stands before it
  const std::string text = DaeTetra(kDaeShown);
  ExpectRead(kTetra, ReadDae(With(text, "<library_geometries>",
                                  "<library_materials><material id=\"g\"/></library_materials>"
                                  "<library_geometries>")));
  ExpectNot("it has several <geometry> of the id 'g'",
            ReadDae(With(text, "</library_geometries>",
                         DaeGeometry("g", kDaePoints, 4, "") + "</library_geometries>")));
  ExpectNot("there is no <geometry> 'n'", ReadDae(DaeTetra("<instance_geometry url=\"#n\"/>")));
}

// ---- Shapes at rest ----

TEST(ColladaReader, MorphsHaveTheirWeights) {
  const std::string shapes = DaeGeometry("g", kDaePoints, 4, kDaeTriangles) +
                             DaeGeometry("t", "0 0 0 1 0 0 0 1 0 0 0 3", 4, "");
  const auto morph = [&](const std::string& method, const std::string& weight) {
    const std::string targets =
        "<source id=\"mt\"><IDREF_array id=\"mi\" count=\"1\">t</IDREF_array></source>" +
        DaeSource("mw", weight, 1, 1) +
        "<targets><input semantic=\"MORPH_TARGET\" source=\"#mt\"/><input "
        "semantic=\"MORPH_WEIGHT\" source=\"#mw\"/></targets>";
    return ReadDae(Collada(shapes, "<node><instance_controller url=\"#c\"/></node>",
                           "<library_controllers><controller id=\"c\"><morph method=\"" + method +
                               "\" source=\"#g\">" + targets +
                               "</morph></controller></library_controllers>"));
  };
  ExpectRead(kTetra, morph("NORMALIZED", "0"));
  ExpectRead(3 * kTetra, morph("NORMALIZED", "1"));
  ExpectRead(2 * kTetra, morph("NORMALIZED", "0.5"));
  // 1 + 1 * 3 high, 1 + 1 wide
  ExpectRead(4 * 2 * 2 * kTetra, morph("RELATIVE", "1"));
}

/// Returns a controller that hangs the tetrahedron on these joints: its top, at 1 above, on the
/// second one, its base on the first.
std::string DaeSkin(const std::string& names, const std::string& array = "Name_array",
                    const std::string& counts = "1 1 1 1",
                    const std::string& pairs = "0 0 0 0 0 0 1 0") {
  const std::string one = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1";
  return "<library_controllers><controller id=\"c\"><skin source=\"#g\"><bind_shape_matrix>" + one +
         "</bind_shape_matrix><source id=\"sj\"><" + array + " id=\"sn\" count=\"2\">" + names +
         "</" + array + "></source>" + DaeSource("sb", one + " " + one, 2, 16) +
         DaeSource("sw", "1", 1, 1) +
         "<joints><input semantic=\"JOINT\" source=\"#sj\"/><input semantic=\"INV_BIND_MATRIX\" "
         "source=\"#sb\"/></joints>"
         "<vertex_weights count=\"4\"><input semantic=\"JOINT\" source=\"#sj\" "
         "offset=\"0\"/><input "
         "semantic=\"WEIGHT\" source=\"#sw\" offset=\"1\"/><vcount>" +
         counts + "</vcount><v>" + pairs +
         "</v></vertex_weights></skin></controller></library_controllers>";
}

/// Returns a skeleton whose second joint stands this high above the first.
std::string DaeSkeleton(const std::string& root, const std::string& tip, int height) {
  return "<node " + root + " type=\"JOINT\"><node " + tip + " type=\"JOINT\"><translate>0 0 " +
         std::to_string(height) + "</translate></node></node>";
}

/// Returns a node on which the skin is shown, with these words in its instance.
std::string DaeSkinned(const std::string& skeleton) {
  return "<node><translate>9 9 9</translate><instance_controller url=\"#c\">" + skeleton +
         "</instance_controller></node>";
}

ReadAnswer ReadSkin(const std::string& nodes, const std::string& skin) {
  return ReadDae(Collada(DaeGeometry("g", kDaePoints, 4, kDaeTriangles), nodes, skin));
}

TEST(ColladaReader, SkinsAreHeldByTheirJoints) {
  const ReadAnswer skinned =
      ReadSkin(DaeSkeleton("sid=\"root\"", "sid=\"tip\"", 4) + DaeSkinned(""), DaeSkin("root tip"));
  ExpectRead(5 * kTetra, skinned);
  EXPECT_EQ(skinned.mesh.points[3], (FilePoint{0, 0, 5}));
}

// Two skeletons have joints of the same sids, as the copies of one figure do.
TEST(ColladaReader, JointsAreThoseOfTheSkeletonOfTheInstance) {
  const std::string two = DaeSkeleton("id=\"a\" sid=\"root\"", "id=\"a-tip\" sid=\"tip\"", 4) +
                          DaeSkeleton("id=\"b\" sid=\"root\"", "id=\"b-tip\" sid=\"tip\"", 6);
  const auto skinned = [&](const std::string& root) {
    return ReadSkin(two + DaeSkinned("<skeleton>#" + root + "</skeleton>"), DaeSkin("root tip"));
  };
  ExpectRead(5 * kTetra, skinned("a"));
  ExpectRead(7 * kTetra, skinned("b"));
  ExpectNot("a skin has a joint 'tip' that stands in several places: name its skeleton",
            ReadSkin(two + DaeSkinned(""), DaeSkin("root tip")));
  // ids are those of the whole file
  ExpectRead(7 * kTetra, ReadSkin(two + DaeSkinned(""), DaeSkin("b b-tip", "IDREF_array")));
  ExpectNot("there is no <node> 'none'", skinned("none"));
  ExpectNot("a skin has a joint 'hand' that stands nowhere",
            ReadSkin(two + DaeSkinned(""), DaeSkin("root hand")));
}

TEST(ColladaReader, NodesOfTheNameOfAJointDoNotStandInForIt) {
  const std::string mesh = "<node name=\"tip\" id=\"x\"><translate>0 0 50</translate></node>";
  const std::string skeleton = DaeSkeleton("id=\"a\" sid=\"root\"", "sid=\"tip\"", 4);
  for (const std::string& nodes : {mesh + skeleton, skeleton + mesh}) {
    ExpectRead(5 * kTetra, ReadSkin(nodes + DaeSkinned(""), DaeSkin("root tip")));
    ExpectRead(5 * kTetra,
               ReadSkin(nodes + DaeSkinned("<skeleton>#a</skeleton>"), DaeSkin("root tip")));
  }
}

TEST(ColladaReader, VerticesThatHangOnNoJointStayAndAreTold) {
  const std::string nodes = DaeSkeleton("sid=\"root\"", "sid=\"tip\"", 4) + DaeSkinned("");
  const ReadAnswer skinned =
      ReadSkin(nodes, DaeSkin("root tip", "Name_array", "0 1 0 1", "0 0 1 0"));
  ExpectReadWith(5 * kTetra, "2 vertices of skins hang on no joint", skinned);
  EXPECT_EQ(skinned.mesh.points[2], (FilePoint{0, 1, 0}));
}

// ---- What is refused ----

TEST(ColladaReader, WordsBehindANumberAreRefused) {
  for (const std::string word : {"1mm", "1,0", "1.0-1", "one"}) {
    ExpectNot("'" + word + "' is not a number",
              ReadDae(With(DaeTetra(kDaeShown), kDaePoints, "0 0 0 1 0 0 0 1 0 0 0 " + word)));
  }
  ExpectNot("uses vertex 4, but there are only 4",
            ReadDae(With(DaeTetra(kDaeShown), "0 3 2</p>", "0 3 4</p>")));
  ExpectNot("no corners of", ReadDae(With(With(DaeTetra(kDaeShown), "0 3 2</p>", "0 3</p>"),
                                          "offset=\"0\"", "offset=\"1\"")));
}

TEST(ColladaReader, PartsAreNodesAndGeometries) {
  ExpectRead(kTetra, ReadDae(DaeTetra(kDaeShown), "n"));
  ExpectRead(kTetra, ReadDae(DaeTetra(kDaeShown), "one"));
  ExpectRead(kTetra, ReadDae(DaeTetra(kDaeShown), "g"));
  ExpectNot("it has no part 'lid', but n", ReadDae(DaeTetra(kDaeShown), "lid"));
}

}  // namespace
}  // namespace tandem
