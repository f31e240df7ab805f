#include "engine/world/world_model.h"

#include <gmock/gmock.h>

#include "tests/support/obj_text.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::Box;
using testing::ObjText;

class LoadedWorld : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_.Write("cube.obj", ObjText(Box(Vec3(0.02, 0.02, 0.02))));
    folder_.Write("slab.obj", ObjText(Box(Vec3(0.06, 0.02, 0.02))));
  }

  std::shared_ptr<const WorldModel> LinearizedForce(const std::string& bodies,
                                                    const std::string& contact = "refined") {
    const Result<Scene> scene =
        LoadScene(folder_.Write("scene.json", R"({"name": "s", "voxel_m": 0.001, "contact": ")" +
                                                  contact + R"(", "bodies": [)" + bodies + "]}"));
    EXPECT_TRUE(scene) << scene.error().what;
    Result<std::shared_ptr<const WorldModel>> world = LoadWorld(*scene);
    EXPECT_TRUE(world) << world.error().what;
    return *world;
  }

  ScratchFolder folder_;
};

// Three cubes side by side are one slab in mass, centre, inertia and surface. Each keeps its own
// mesh and colour. The whole stands turned, and its parts are named before and after it.
TEST_F(LoadedWorld, MergedPartsFormOneBodyWithAllMeshes) {
  const auto pose = [](double x) {
    return "\"pose\": {\"p_W\": [" + std::to_string(x) + ", 0, 0], \"q_xyzw\": [0, 0, 1, 0]}";
  };
  const auto merged = LinearizedForce(
      R"({"name": "left", "mesh": "cube.obj", "merge_with": "middle", "colour": "#ff0000",)" +
      pose(0.08) + R"(}, {"name": "middle", "mesh": "cube.obj", "density_kg_m3": 1000,)" +
      pose(0.10) + R"(}, {"name": "right", "mesh": "cube.obj", "merge_with": "middle",)" +
      pose(0.12) + "}");
  const auto slab = LinearizedForce(
      R"({"name": "slab", "mesh": "slab.obj", "density_kg_m3": 1000,)" + pose(0.10) + "}");
  ASSERT_EQ(merged->bodies.size(), 1U);
  EXPECT_EQ(merged->body_index, (std::vector<int>{0, 0, 0}));
  EXPECT_EQ(merged->object, (std::vector<std::uint32_t>{1}));
  EXPECT_EQ(merged->BodyNamed("right"), 0);
  ASSERT_EQ(merged->meshes_W.size(), 3U);
  EXPECT_EQ(merged->scene.bodies[0].colour[0], 1.0F);

  const BodyModel& body = merged->bodies[0];
  const BodyModel& same = slab->bodies[0];
  EXPECT_EQ(body.name, "middle");
  // the importer's numbers are of single precision
  EXPECT_NEAR(body.inertia.mass, 0.024, 1e-8);
  EXPECT_LT((body.inertia.I_B - same.inertia.I_B).norm(), 1e-6 * same.inertia.I_B.norm());
  EXPECT_LT((body.X_WB0.p - same.X_WB0.p).norm(), 1e-9);
  EXPECT_LT(RotationVector(body.X_WB0.q * same.X_WB0.q.conjugate()).norm(), 1e-9);
  EXPECT_NEAR(body.radius, same.radius, 1e-8);
  // the points are those of all three: the cubes' inner walls count as well
  EXPECT_GT(body.surface_points, same.surface_points);
  EXPECT_GE(TestedPoints(*merged, body), TestedPoints(*slab, same));
}

// Bars of 60 mm that overlap by 20 make one of 100 mm. Its mass by density is that of the whole, in
// one mesh as in merged parts, and so are its centre and inertia.
TEST_F(LoadedWorld, OverlappingSolidsWeighWhatTheirUnionDoes) {
  TriangleMesh two = Box(Vec3(0.06, 0.02, 0.02));
  Append(two, testing::At(Box(Vec3(0.06, 0.02, 0.02)), Vec3(0.04, 0, 0)));
  folder_.Write("two.obj", ObjText(two));
  folder_.Write("long.obj", ObjText(testing::At(Box(Vec3(0.1, 0.02, 0.02)), Vec3(0.02, 0, 0))));
  const std::string weighs = R"("density_kg_m3": 1000)";
  const auto single = LinearizedForce(R"({"name": "long", "mesh": "long.obj", )" + weighs + "}");
  const auto in_one = LinearizedForce(R"({"name": "two", "mesh": "two.obj", )" + weighs + "}");
  const auto merged = LinearizedForce(
      R"({"name": "a", "mesh": "slab.obj", )" + weighs +
      R"(}, {"name": "b", "mesh": "slab.obj", "merge_with": "a", "pose": {"p_W": [0.04, 0, 0]}})");
  for (const auto& world : {in_one, merged}) {
    EXPECT_NEAR(world->bodies[0].inertia.mass, 0.04, 1e-7);
    EXPECT_LT((world->bodies[0].X_WB0.p - single->bodies[0].X_WB0.p).norm(), 1e-7);
    EXPECT_LT((world->bodies[0].inertia.I_B - single->bodies[0].inertia.I_B).norm(),
              1e-5 * single->bodies[0].inertia.I_B.norm());
  }
}

// A mesh of two cubes of 2 cm, one of which is wound inside out, weighs as much as both.
TEST_F(LoadedWorld, MassByDensityCountsAShellThatIsWoundInsideOut) {
  TriangleMesh cubes = Box(Vec3(0.02, 0.02, 0.02));
  TriangleMesh other = Box(Vec3(0.02, 0.02, 0.02));
  for (Vec3& vertex : other.vertices) vertex.x() += 0.05;
  for (TriangleMesh::Triangle& t : other.triangles) std::swap(t[1], t[2]);
  Append(cubes, other);
  folder_.Write("two.obj", ObjText(cubes));
  const auto world =
      LinearizedForce(R"({"name": "c", "mesh": "two.obj", "density_kg_m3": 1000, "free": true})");
  EXPECT_NEAR(world->bodies[0].inertia.mass, 0.016, 1e-8);
  EXPECT_THAT(world->remarks, ::testing::IsEmpty());
}

TEST_F(LoadedWorld, MassByDensityOfAnOpenSurfaceIsToldAsAnEstimate) {
  TriangleMesh open = Box(Vec3(0.02, 0.02, 0.02));
  open.triangles.pop_back();
  folder_.Write("open.obj", ObjText(open));
  const auto remarks = [this](const std::string& mass) {
    return LinearizedForce(R"({"name": "c", "mesh": "open.obj", )" + mass + R"(, "free": true})")
        ->remarks;
  };
  const std::string words = "by density_kg_m3 is an estimate, for its surface encloses no sound";
  EXPECT_THAT(remarks("\"density_kg_m3\": 1000"), ::testing::Contains(::testing::HasSubstr(words)));
  EXPECT_THAT(remarks("\"mass_kg\": 1"),
              ::testing::Not(::testing::Contains(::testing::HasSubstr(words))));
}

// Statements of a mesh file that its reader leaves out are remarks of the world, by body.
TEST_F(LoadedWorld, RemarksOfMeshFilesNameTheirBody) {
  folder_.Write("lines.obj", ObjText(Box(Vec3(0.02, 0.02, 0.02))) + "l 1 2\n");
  const auto world = LinearizedForce(R"({"name": "c", "mesh": "lines.obj", "mass_kg": 1})");
  ASSERT_EQ(world->remarks.size(), 1U);
  EXPECT_THAT(world->remarks[0], ::testing::StartsWith("body 'c' ("));
  EXPECT_THAT(world->remarks[0],
              ::testing::HasSubstr("): 1 line or point element without a surface left out"));
}

// Neither points nor voxels are kept where contact reads none of them; benches make both.
TEST_F(LoadedWorld, BuildsOnlyWhatItsContactModelReads) {
  const std::string bodies =
      R"({"name": "a", "mesh": "cube.obj", "mass_kg": 1},
         {"name": "b", "mesh": "cube.obj", "mass_kg": 1, "pose": {"p_W": [0.05, 0, 0]}},
         {"name": "c", "mesh": "cube.obj", "fixed": true, "pose": {"p_W": [0.1, 0, 0]}})";
  const auto plain = LinearizedForce(bodies, "plain");
  const auto refined = LinearizedForce(bodies);
  EXPECT_TRUE(plain->fixture_surface.field.empty());
  EXPECT_FALSE(plain->fixture.empty());
  EXPECT_TRUE(refined->fixture.empty());
  EXPECT_FALSE(refined->fixture_surface.field.empty());
  for (std::size_t b = 0; b < 2; ++b) {
    EXPECT_EQ(refined->bodies[b].points.size(), 0U);
    EXPECT_TRUE(refined->bodies[b].voxmap.empty());
    EXPECT_TRUE(plain->bodies[b].surface.field.empty());
    // half a cube's diagonal; points stand in the middles of voxels
    EXPECT_NEAR(refined->bodies[b].radius, 0.01 * std::sqrt(3), 1e-8);
    EXPECT_NEAR(plain->bodies[b].radius, 0.01 * std::sqrt(3), 0.001);
    // 6 faces of 400 square voxels
    EXPECT_NEAR(refined->bodies[b].surface_points, 2400, 1);
    EXPECT_GT(TestedPoints(*refined, refined->bodies[b]), 200U);  // 12 edges of 20 voxels
    EXPECT_LT(TestedPoints(*refined, refined->bodies[b]), 300U);
  }
  WorldModel both = *refined;
  ASSERT_FALSE(AddPlainParts(both));
  EXPECT_EQ(both.fixture.Count().surface, plain->fixture.Count().surface);
  EXPECT_EQ(both.bodies[1].voxmap.Count().surface, plain->bodies[1].voxmap.Count().surface);
  EXPECT_GT(both.bodies[0].points.size(), 2000U);
}

// Outwards a cube's faces and edges part; inwards they come together.
TEST_F(LoadedWorld, ReportsDisplacedPointsWithGapsOverAVoxel) {
  const auto remarks = [this](const std::string& shift) {
    return LinearizedForce(
               R"({"name": "c", "mesh": "cube.obj", "mass_kg": 1, "inward_shift_voxels": )" +
                   shift + "}",
               "plain")
        ->remarks;
  };
  EXPECT_THAT(remarks("0"), ::testing::IsEmpty());
  EXPECT_THAT(remarks("0.25"), ::testing::IsEmpty());
  const std::vector<std::string> outwards = remarks("-0.5");
  ASSERT_EQ(outwards.size(), 1U);
  EXPECT_THAT(outwards[0], ::testing::HasSubstr("its displaced points stand up to 1."));
}

// A cube's faces part by as much as they are displaced; a hundredth of a voxel is nothing to tell.
TEST_F(LoadedWorld, DoesNotWarnOfAGapOfOneVoxel) {
  const auto world = LinearizedForce(R"({"name": "c", "mesh": "cube.obj", "mass_kg": 1})", "plain");
  const BodyModel& cube = world->bodies[0];
  const double voxel = world->scene.voxel_size;
  const double small = -1e-4 * voxel;
  ASSERT_GT(cube.points.GapWhenDisplaced(small), (1 + 1e-6) * voxel);
  EXPECT_EQ(GapRemark(world->scene, cube, small), std::nullopt);
  EXPECT_TRUE(GapRemark(world->scene, cube, -0.1 * voxel));
}

// A bracket of 47 mm in a file of millimetres, read as metres.
TEST_F(LoadedWorld, MissingScaleIsSuggestedInsteadOfLargerVoxels) {
  folder_.Write("mm.obj", ObjText(Box(Vec3(47, 131, 6))));
  for (const char* kind : {R"("fixed": true)", R"("mass_kg": 1)"}) {
    const Result<Scene> scene =
        LoadScene(folder_.Write("mm.json", R"({"name": "s", "voxel_m": 0.001, "bodies": [
            {"name": "cube", "mesh": "cube.obj", "mass_kg": 1},
            {"name": "bracket", "mesh": "mm.obj", )" +
                                               std::string(kind) + "}]}"));
    ASSERT_TRUE(scene) << scene.error().what;
    const auto world = LoadWorld(*scene);
    ASSERT_FALSE(world);
    EXPECT_THAT(world.error().what,
                ::testing::HasSubstr("it measures 47 x 131 x 6 m: is the file in millimetres? "
                                     "Then give it \"scale\": 0.001 ("));
    EXPECT_THAT(world.error().what, ::testing::HasSubstr("body 'bracket'"));
  }
}

// A user who gives the scale of a plate of 3 m, be it 1, is not asked for it.
TEST_F(LoadedWorld, GivenScaleIsNotSuggested) {
  folder_.Write("plate.obj", ObjText(Box(Vec3(0.01, 3, 0.01))));
  const auto remarks = [this](const std::string& scale) {
    return LinearizedForce(R"({"name": "c", "mesh": "plate.obj", "mass_kg": 1)" + scale + "}")
        ->remarks;
  };
  EXPECT_THAT(remarks(""), ::testing::ElementsAre(::testing::HasSubstr("in millimetres?")));
  EXPECT_THAT(remarks(R"(, "scale": 1)"), ::testing::IsEmpty());
}

// Table 1 of the paper: 1.0 mm in 2.5 mm voxels. Points that part when they are displaced outwards
// are the reason (§3.2): 1.4 voxels apart at a spacing of a voxel, half as far at 0.4.
TEST_F(LoadedWorld, PointsFinerThanVoxelsComeFromTheScene) {
  const auto body = [this](const std::string& keys) {
    return LinearizedForce(R"({"name": "c", "mesh": "cube.obj", "mass_kg": 1)" + keys + "}",
                           "plain");
  };
  const auto one = body("");
  const auto finer = body(", \"point_spacing_voxels\": 0.4");
  EXPECT_DOUBLE_EQ(finer->bodies[0].points.spacing, 0.0004);
  const double points = static_cast<double>(one->bodies[0].points.size());
  EXPECT_NEAR(static_cast<double>(finer->bodies[0].points.size()), points / 0.16,
              0.1 * points / 0.16);
  const auto parted = body(", \"inward_shift_voxels\": -0.3");
  const auto together = body(", \"inward_shift_voxels\": -0.3, \"point_spacing_voxels\": 0.4");
  EXPECT_EQ(parted->remarks.size(), 1U);
  EXPECT_THAT(together->remarks, ::testing::IsEmpty());
  // a voxel outwards parts finer ones too, and is as far beyond the points as any displacement
  EXPECT_TRUE(GapRemark(together->scene, together->bodies[0], -0.001));
}

// A scene that was made or changed in code is held to what a scene file is.
TEST_F(LoadedWorld, RefusesALayerThatMissesContacts) {
  Scene scene = LinearizedForce(R"({"name": "c", "mesh": "cube.obj", "mass_kg": 1})")->scene;
  scene.force_layer = 0;
  const auto refused = LoadWorld(scene);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().what, ::testing::HasSubstr("layer 1 finds them all"));
  scene.contact = ContactModel::kPlain;
  EXPECT_TRUE(LoadWorld(scene));
}

TEST_F(LoadedWorld, ConstraintHoldsABodyInPlace) {
  const auto world = LinearizedForce(
      R"({"name": "lid", "mesh": "slab.obj", "mass_kg": 0.2, "pose": {"p_W": [0.03, 0, 0]},
          "constraint": {"hinge": {"p_W": [0, 0, 0], "axis_W": [0, 2, 0]}}},
         {"name": "box", "mesh": "cube.obj", "mass_kg": 0.2, "pose": {"p_W": [0, 0, 0.1]}})");
  ASSERT_TRUE(world->bodies[0].constraint);
  EXPECT_FALSE(world->bodies[1].constraint);
  const Pose& X_WB0 = world->bodies[0].X_WB0;
  const Pose turned = Pose{RotationBy(Vec3(0, 0.7, 0)), Vec3::Zero()} * X_WB0;
  const Pose nearest = world->bodies[0].constraint->Nearest(turned);
  EXPECT_LT((nearest.p - turned.p).norm(), 1e-12);
  const Pose lifted{X_WB0.q, X_WB0.p + Vec3(0.01, 0.02, 0.03)};
  EXPECT_LT((world->bodies[0].constraint->Nearest(lifted).p - X_WB0.p).norm(), 1e-12);
}

}  // namespace
}  // namespace tandem
