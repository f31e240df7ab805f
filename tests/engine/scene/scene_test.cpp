#include "engine/scene/scene.h"

#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <sys/stat.h>

#include "tests/engine/scene/scene_file_fixture.h"

namespace tandem {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;
using testing::kScene;
using testing::SceneFile;

TEST_F(SceneFile, IsReadInFull) {
  const Result<Scene> loaded = LoadScene(File(kScene));
  ASSERT_TRUE(loaded) << loaded.error().what;
  const Scene& scene = *loaded;
  EXPECT_EQ(scene.name, "peg");
  EXPECT_EQ(scene.voxel_size, 0.0005);
  EXPECT_EQ(scene.force_layer, 1);
  ASSERT_EQ(scene.bodies.size(), 3U);

  const SceneBody& block = scene.bodies[0];
  EXPECT_TRUE(block.fixed);
  EXPECT_EQ(block.scale, std::nullopt);
  EXPECT_EQ(block.mass, 0.0);
  EXPECT_EQ(block.colour[0], 1.0F);
  EXPECT_NEAR(block.colour[1], 0.502, 0.001);  // 0x80 of 0xff
  EXPECT_EQ(block.colour[2], 0.0F);

  const SceneBody& peg = scene.bodies[1];
  EXPECT_FALSE(peg.fixed);
  EXPECT_TRUE(peg.shared);
  EXPECT_EQ(peg.scale, 0.001);
  EXPECT_EQ(peg.mass, 0.3);
  EXPECT_EQ(peg.inward_shift_voxels, 0.5);
  EXPECT_EQ(peg.X_WM.p, Vec3(0.1, 0.2, 0.3));
  EXPECT_NEAR(peg.X_WM.q.z(), 0.6, 1e-15);
  EXPECT_NEAR(peg.X_WM.q.w(), 0.8, 1e-15);

  EXPECT_EQ(scene.bodies[2].mass, 0.0);
  EXPECT_EQ(scene.bodies[2].density, 2700.0);
  EXPECT_FALSE(scene.bodies[2].shared);

  ASSERT_EQ(scene.hands.size(), 1U);
  EXPECT_EQ(scene.hands[0].body, "peg");
  EXPECT_EQ(scene.BodyNamed("ring"), 2);
  EXPECT_EQ(scene.BodyNamed("nut"), -1);
}

TEST_F(SceneFile, MovingBodiesAreNotGreyByDefault) {
  const Result<Scene> scene = LoadScene(File(Changed(", \"colour\": \"#ff8000\"", "")));
  ASSERT_TRUE(scene);
  const auto& block = scene->bodies[0].colour;
  EXPECT_TRUE(block[0] == block[1] && block[1] == block[2]) << "fixed";
  EXPECT_NE(scene->bodies[1].colour, block);
  EXPECT_NE(scene->bodies[2].colour, block);
  EXPECT_NE(scene->bodies[1].colour, scene->bodies[2].colour);
}

TEST_F(SceneFile, HandFileIsNotTakenForAScene) {
  EXPECT_EQ(ErrorOf("\"colour\": \"#000000\"", "\"waypoints\": [],"),
            "this is a hand's script, not a scene: --hand takes it");
}

TEST_F(SceneFile, ResolvesPathsRelativeToItself) {
  const Result<Scene> scene = LoadScene(File(kScene));
  ASSERT_TRUE(scene);
  EXPECT_EQ(scene->bodies[0].mesh, folder_.path() / "block.stl");
  EXPECT_EQ(scene->hands[0].file, folder_.path() / "left.json");
}

TEST_F(SceneFile, PointSpacingIsPerSceneOrBody) {
  const auto spacings = [&](const std::string& of_ring, const std::string& of_scene) {
    const Result<Scene> scene = LoadScene(File(WithKeys(of_ring, of_scene)));
    EXPECT_TRUE(scene) << scene.error().what;
    return std::pair(scene->bodies[1].point_spacing_voxels, scene->bodies[2].point_spacing_voxels);
  };
  const std::string free = "\"free\": false";
  EXPECT_EQ(spacings(free, ""), std::pair(1.0, 1.0));
  EXPECT_EQ(spacings(free, "\"point_spacing_voxels\": 0.5,"), std::pair(0.5, 0.5));
  EXPECT_EQ(spacings("\"point_spacing_voxels\": 0.4", "\"point_spacing_voxels\": 0.5,"),
            std::pair(0.5, 0.4));

  EXPECT_EQ(ErrorOf("\"point_spacing_voxels\": 1.5"),
            "bodies[2].point_spacing_voxels: expected a number above 0 and at most 1: a part of a "
            "voxel, got 1.5");
  EXPECT_EQ(ErrorOf(free, "\"point_spacing_voxels\": 0,"),
            "point_spacing_voxels: expected a number above 0, got 0");
  EXPECT_EQ(ErrorAfter("\"fixed\": true", "\"fixed\": true, \"point_spacing_voxels\": 0.5"),
            "bodies[0].point_spacing_voxels: a fixed body has none");
  EXPECT_EQ(ErrorAfter("\"density_kg_m3\": 2700",
                       "\"merge_with\": \"peg\", \"point_spacing_voxels\": 0.5"),
            "bodies[2].point_spacing_voxels: give it to the body that this one is merged with");
}

TEST_F(SceneFile, PlainContactAcceptsAnyLayer) {
  EXPECT_EQ(LoadScene(File(Changed("\"force_layer\": 1", "\"contact\": \"plain\"")))->force_layer,
            2);
  const std::string at_surface = "\"contact\": \"plain\", \"force_layer\": 0";
  EXPECT_EQ(LoadScene(File(Changed("\"force_layer\": 1", at_surface)))->force_layer, 0);
}

TEST_F(SceneFile, ErrorsNameThePositionAndTheExpectation) {
  EXPECT_EQ(ErrorAfter("\"mass_kg\": 0.3", "\"mass_kg\": \"heavy\""),
            "bodies[1].mass_kg: expected a number above 0, got \"heavy\"");
  EXPECT_EQ(ErrorAfter("\"mass_kg\": 0.3", "\"mass_kg\": -1"),
            "bodies[1].mass_kg: expected a number above 0, got -1");
  EXPECT_EQ(ErrorAfter("\"voxel_m\": 0.0005,", ""),
            "voxel_m: expected a number above 0, got nothing");
  EXPECT_EQ(ErrorAfter("\"force_layer\": 1", "\"force_layer\": 7"),
            "force_layer: expected a whole number from 0 to 6, got 7");
  EXPECT_EQ(ErrorAfter("\"force_layer\": 1", "\"force_layer\": 0"),
            "force_layer: refined contact misses contacts at force layer 0: layer 1 finds them all "
            "(plain contact works with 0)");
  EXPECT_EQ(ErrorAfter("\"force_layer\": 1", "\"force_layer\": 1.5"),
            "force_layer: expected a whole number from 0 to 6, got 1.5");
  EXPECT_EQ(ErrorAfter("\"force_layer\": 1", "\"force_layer\": 4, \"range_voxels\": 5"),
            "force_layer: expected a whole number from 0 to 3, got 4");
  EXPECT_EQ(ErrorAfter("\"force_layer\": 1", "\"range_voxels\": 253"),
            "range_voxels: expected a whole number from 4 to 252, got 253");
  EXPECT_EQ(ErrorAfter("\"force_layer\": 1", "\"clearance_range_voxels\": 33"),
            "clearance_range_voxels: expected a number from 1.5 to 32, got 33");
  EXPECT_EQ(ErrorAfter("\"force_layer\": 1", "\"fine_band_voxels\": 1.5"),
            "fine_band_voxels: expected a number from 0.1 to 1, got 1.5");
  EXPECT_EQ(ErrorAfter("[0.1, 0.2, 0.3]", "[0.1, 0.2]"),
            "bodies[1].pose.p_W: expected three numbers [x, y, z], got [0.1,0.2]");
  EXPECT_EQ(ErrorAfter("[0.1, 0.2, 0.3]", "[0.1, \"y\", 0.3]"),
            "bodies[1].pose.p_W[1]: expected a number, got \"y\"");
  EXPECT_EQ(ErrorAfter("[0, 0, 0.6, 0.8]", "[0, 0, 1, 1]"),
            "bodies[1].pose.q_xyzw: expected a rotation [x, y, z, w] of length 1, got [0,0,1,1]");
  EXPECT_EQ(ErrorAfter("\"fixed\": true", "\"fixed\": 1"),
            "bodies[0].fixed: expected true or false, got 1");
  EXPECT_EQ(ErrorAfter("#ff8000", "red"),
            "bodies[0].colour: expected a colour like \"#4080c0\", got \"red\"");
  EXPECT_EQ(ErrorAfter("\"shared\"", "\"both\""),
            "bodies[1].sharing: expected \"own\" (one user holds it) or \"shared\" (several may "
            "hold it at once), got \"both\"");
}

TEST_F(SceneFile, ErrorsExplainInconsistentValues) {
  EXPECT_EQ(ErrorAfter("\"mass_kg\": 0.3, ", ""),
            "bodies[1]: expected \"fixed\": true, or a mass_kg or a density_kg_m3");
  EXPECT_EQ(ErrorAfter("\"fixed\": true", "\"fixed\": true, \"mass_kg\": 1"),
            "bodies[0].mass_kg: a fixed body has none");
  EXPECT_EQ(ErrorAfter("\"mass_kg\": 0.3", "\"mass_kg\": 0.3, \"density_kg_m3\": 1000"),
            "bodies[1].density_kg_m3: the mass is given already; give one of the two");
  EXPECT_EQ(ErrorAfter("\"name\": \"ring\"", "\"name\": \"peg\""),
            "bodies[2].name: another body has this name already");
  EXPECT_EQ(ErrorAfter("\"body\": \"peg\"", "\"body\": \"block\""),
            "hands[0].body: expected the name of a body that moves, got \"block\"");
  EXPECT_THAT(ErrorAfter("\"block.stl\"", "\"blok.stl\""),
              HasSubstr("bodies[0].mesh: no such file: "));
  EXPECT_THAT(ErrorAfter("\"left.json\"", "\"l.json\""),
              HasSubstr("hands[0].file: no such file: "));
}

TEST_F(SceneFile, ReadsGravityFrictionAndPairs) {
  const Result<Scene> loaded = LoadScene(File(
      WithKeys(R"("free": true, "constraint": {"plane": {"normal_W": [0, 0, 2], "turn": "free"}})",
               R"("friction": 0.4, "gravity_m_s2": [0, 0, -9.81],
          "pairs": [{"pointshell": "ring", "voxmap": "peg"}],)")));
  ASSERT_TRUE(loaded) << loaded.error().what;
  EXPECT_EQ(loaded->gravity_W, Vec3(0, 0, -9.81));
  EXPECT_EQ(loaded->friction, 0.4);
  ASSERT_EQ(loaded->pairs.size(), 1U);
  EXPECT_EQ(loaded->pairs[0].pointshell, "ring");
  EXPECT_EQ(loaded->pairs[0].voxmap, "peg");
  const SceneBody& ring = loaded->bodies[2];
  EXPECT_TRUE(ring.free);
  EXPECT_EQ(ring.constraint.kind, SceneConstraint::Kind::kPlane);
  EXPECT_EQ(ring.constraint.axis_W, Vec3(0, 0, 2));
  EXPECT_EQ(ring.constraint.turn, Constraint::Turn::kFree);
  const SceneBody& peg = loaded->bodies[1];
  EXPECT_FALSE(peg.free);
  EXPECT_EQ(peg.constraint.kind, SceneConstraint::Kind::kNone);
}

TEST_F(SceneFile, ReadsEveryKindOfConstraint) {
  using Kind = SceneConstraint::Kind;
  const std::string axis = R"({"p_W": [1, 2, 3], "axis_W": [0, 1, 0]}})";
  for (const auto& [text, kind] : std::vector<std::pair<std::string, Kind>>{
           {"{\"hinge\": " + axis, Kind::kHinge},
           {"{\"cylinder\": " + axis, Kind::kCylinder},
           {R"({"slide": {"axis_W": [0, 1, 0]}})", Kind::kSlide},
           {R"({"plane": {"normal_W": [0, 1, 0]}})", Kind::kPlane},
           {R"({"ball": {"p_W": [1, 2, 3]}})", Kind::kBall}}) {
    const Result<Scene> scene = LoadScene(File(WithKeys("\"constraint\": " + text)));
    ASSERT_TRUE(scene) << scene.error().what;
    const SceneConstraint& constraint = scene->bodies[2].constraint;
    EXPECT_EQ(constraint.kind, kind) << text;
    if (kind == Kind::kHinge || kind == Kind::kCylinder || kind == Kind::kBall) {
      EXPECT_EQ(constraint.p_W, Vec3(1, 2, 3)) << text;
    }
    if (kind != Kind::kBall) {
      EXPECT_EQ(constraint.axis_W, Vec3::UnitY()) << text;
    }
  }
}

TEST_F(SceneFile, ErrorsExplainInvalidConstraints) {
  EXPECT_EQ(ErrorOf(R"("constraint": {})"),
            "bodies[2].constraint: expected one of hinge, slide, cylinder, plane, ball; got 0 of "
            "them");
  EXPECT_EQ(
      ErrorOf(R"("constraint": {"ball": {"p_W": [0, 0, 0]}, "slide": {"axis_W": [1, 0, 0]}})"),
      "bodies[2].constraint: expected one of hinge, slide, cylinder, plane, ball; got 2 of "
      "them");
  EXPECT_EQ(ErrorOf(R"("constraint": {"hing": {}})"),
            "bodies[2].constraint.hing: unknown key; did you mean hinge?");
  EXPECT_EQ(
      ErrorOf(R"("constraint": {"hinge": {"p_W": [0, 0, 0], "axis_W": [0, 0, 0]}})"),
      "bodies[2].constraint.hinge.axis_W: expected a direction [x, y, z] of a length from 1e-9 to "
      "1e9, got [0,0,0]");
  // a length whose square is too large for a number
  EXPECT_EQ(
      ErrorOf(R"("constraint": {"hinge": {"p_W": [0, 0, 0], "axis_W": [1e200, 0, 0]}})"),
      "bodies[2].constraint.hinge.axis_W: expected a direction [x, y, z] of a length from 1e-9 to "
      "1e9, got [1e+200,0,0]");
  EXPECT_EQ(ErrorOf(R"("constraint": {"hinge": {"axis_W": [0, 0, 1]}})"),
            "bodies[2].constraint.hinge.p_W: expected three numbers [x, y, z], got nothing");
  EXPECT_EQ(ErrorOf(R"("constraint": {"plane": {"normal_W": [0, 0, 1], "turn": "yes"}})"),
            "bodies[2].constraint.plane.turn: expected \"about_normal\", \"free\" or \"none\", got "
            "\"yes\"");
  EXPECT_EQ(
      ErrorAfter("\"fixed\": true", R"("fixed": true, "constraint": {"ball": {"p_W": [0, 0, 0]}})"),
      "bodies[0].constraint: a fixed body has none");
  EXPECT_EQ(ErrorAfter("\"fixed\": true", "\"fixed\": true, \"free\": true"),
            "bodies[0].free: a fixed body has none");
  EXPECT_EQ(ErrorOf("\"free\": 1"), "bodies[2].free: expected true or false, got 1");
}

TEST_F(SceneFile, ErrorsExplainInvalidGravityFrictionAndPairs) {
  const auto error = [&](const std::string& keys) {
    return ErrorOf("\"free\": true", keys + ",");
  };
  EXPECT_EQ(error("\"gravity_m_s2\": 9.81"),
            "gravity_m_s2: expected three numbers [x, y, z], got 9.81");
  EXPECT_EQ(error("\"friction\": -0.1"), "friction: expected a number from 0 to 100, got -0.1");
  EXPECT_EQ(error("\"friction\": 1e300"), "friction: expected a number from 0 to 100, got 1e+300");
  EXPECT_EQ(error(R"("pairs": [{"pointshell": "ring", "voxmap": "block"}])"),
            "pairs[0].voxmap: expected the name of a body that moves, got \"block\"");
  EXPECT_EQ(error(R"("pairs": [{"pointshell": "nut", "voxmap": "peg"}])"),
            "pairs[0].pointshell: expected the name of a body that moves, got \"nut\"");
  EXPECT_EQ(error(R"("pairs": [{"pointshell": "peg", "voxmap": "peg"}])"),
            "pairs[0].voxmap: expected the name of another body, got \"peg\"");
  EXPECT_EQ(error(R"("pairs": [{"pointshell": "peg", "voxmap": "ring"},
                               {"pointshell": "ring", "voxmap": "peg"}])"),
            "pairs[1]: this pair is given already");
}

TEST_F(SceneFile, MergedPartsFollowTheirBody) {
  const std::string merged = Changed("\"density_kg_m3\": 2700", "\"merge_with\": \"peg\"");
  const Result<Scene> scene = LoadScene(File(merged));
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_EQ(scene->WholeOf(2), 1U);
  EXPECT_EQ(scene->WholeOf(1), 1U);
  EXPECT_EQ(scene->WholeOf(0), 0U);
  EXPECT_NE(Hash(merged), Hash(kScene));

  const auto error = [&](const std::string& key) {
    return ErrorAfter("\"density_kg_m3\": 2700", key);
  };
  constexpr auto kNotAWhole =
      "bodies[2].merge_with: expected the name of a body that moves and is not merged itself, got ";
  EXPECT_EQ(error("\"merge_with\": \"block\""), kNotAWhole + std::string("\"block\""));
  EXPECT_EQ(error("\"merge_with\": \"nut\""), kNotAWhole + std::string("\"nut\""));
  EXPECT_EQ(error("\"merge_with\": \"ring\""), kNotAWhole + std::string("\"ring\""));
  EXPECT_EQ(error("\"merge_with\": \"peg\", \"mass_kg\": 1"),
            "bodies[2].mass_kg: give it to the body that this one is merged with");
  std::string text = merged;
  text.replace(text.find("\"body\": \"peg\""), 13, "\"body\": \"ring\"");
  const Result<Scene> held = LoadScene(File(text));
  ASSERT_FALSE(held);
  EXPECT_THAT(held.error().what, EndsWith("hands[0].body: \"ring\" is merged; name \"peg\""));
}

TEST_F(SceneFile, MisspeltKeysSuggestTheNearestKnownOne) {
  EXPECT_EQ(ErrorAfter("\"mass_kg\"", "\"mas_kg\""),
            "bodies[1].mas_kg: unknown key; did you mean mass_kg?");
  EXPECT_EQ(ErrorAfter("\"mass_kg\"", "\"mass\""),
            "bodies[1].mass: unknown key; did you mean mass_kg?");
  EXPECT_EQ(ErrorAfter("\"name\": \"peg\",", "\"name\": \"peg\", \"gravity\": 9.81,"),
            "gravity: unknown key; did you mean gravity_m_s2?");
  EXPECT_EQ(ErrorAfter("\"name\": \"peg\",", "\"name\": \"peg\", \"wind\": 9.81,"),
            "wind: unknown key; known here are name voxel_m range_voxels fine_band_voxels "
            "clearance_range_voxels contact force_layer friction "
            "point_spacing_voxels gravity_m_s2 bodies pairs hands");
}

TEST_F(SceneFile, SyntaxErrorsNameLineAndColumn) {
  // line 3 loses its comma, so the key of line 4 comes as a surprise
  EXPECT_THAT(ErrorAfter("0.0005,", "0.0005"), HasSubstr("line 4, column "));
  EXPECT_THAT(ErrorAfter("\"name\": \"peg\",", "\"name\": \"peg\", \"name\": \"pin\","),
              EndsWith("the key \"name\" is given twice"));
}

TEST_F(SceneFile, MissingFileIsReportedInOneLine) {
  const Result<Scene> scene = LoadScene(folder_.path() / "none.json");
  ASSERT_FALSE(scene);
  EXPECT_EQ(scene.error().what,
            (folder_.path() / "none.json").string() + ": there is no such file");
  EXPECT_FALSE(LoadScene(folder_.path()));
}

TEST_F(SceneFile, TruncatedFileIsAnErrorAndNeverACrash) {
  const std::size_t end = kScene.rfind('}');
  for (std::size_t length = 0; length <= end; ++length) {
    EXPECT_FALSE(LoadScene(File(kScene.substr(0, length)))) << length;
  }
}

// A shift of a hundred thousand voxels must not end the program when its contact is set up.
TEST_F(SceneFile, ImplausibleNumbersAreRefused) {
  for (const char* shift : {"-1e5", "17", "-1e300"}) {
    EXPECT_THAT(ErrorAfter("\"inward_shift_voxels\": 0.5",
                           std::string("\"inward_shift_voxels\": ") + shift),
                HasSubstr("inward_shift_voxels: expected a number from -16 to 16, got "));
  }
}

TEST_F(SceneFile, GravityIsBounded) {
  EXPECT_THAT(
      ErrorAfter("\"name\": \"peg\",", "\"name\": \"peg\", \"gravity_m_s2\": [0, 0, -1e300],"),
      HasSubstr("gravity_m_s2: expected three numbers from -1000 to 1000"));
}

TEST_F(SceneFile, ListLengthsAreBounded) {
  const auto many = [&](const std::string& list, int count) {
    std::string items = "{}";
    for (int i = 1; i < count; ++i) items += ",{}";
    const Result<Scene> scene =
        LoadScene(File(R"({"name": "s", "voxel_m": 1, ")" + list + "\": [" + items + "]}"));
    return scene ? std::string() : scene.error().what;
  };
  EXPECT_THAT(many("bodies", 1025), EndsWith("bodies: more than 1024"));
  EXPECT_THAT(many("pairs", 257), EndsWith("pairs: more than 256"));
  EXPECT_THAT(many("hands", 65), EndsWith("hands: more than 64"));
}

TEST_F(SceneFile, PipeIsRefused) {
  const auto pipe = folder_.path() / "pipe.json";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const Result<Scene> scene = LoadScene(pipe);
  ASSERT_FALSE(scene);
  EXPECT_EQ(scene.error().what,
            pipe.string() + ": cannot be read: it is not a regular file, name a file");
}

}  // namespace
}  // namespace tandem
