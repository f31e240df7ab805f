#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <ostream>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "engine/scene/scene.h"
#include "scenes/generators/generated_scene.h"
#include "scenes/generators/generator_command.h"
#include "tests/scenes/generators/solid_probe.h"
#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

constexpr double kMm = 1e-3;

std::string Bytes(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

/// A scene with its files in a folder of its own, and its shapes (mm, W) as fixed and moving.
struct LoadedScene {
  explicit LoadedScene(const GeneratedScene& made) : generated(made) {
    EXPECT_FALSE(WriteScene(made, folder.path()));
    const std::string file = made.name + ".json";
    std::filesystem::copy_file(std::filesystem::path(TANDEM_SCENE_FILES) / file,
                               folder.path() / file);
    const Result<Scene> loaded = LoadScene(folder.path() / file);
    EXPECT_TRUE(loaded) << loaded.error().what;
    scene = *loaded;
    for (const SceneBody& body : scene.bodies) {
      EXPECT_EQ(body.scale, kMm);
      EXPECT_TRUE(body.X_WM.p.isZero());
      Append(body.fixed ? fixed : moving, MeshOf(body));
    }
  }

  const TriangleMesh& MeshOf(const SceneBody& body) const {
    const auto found = std::find_if(generated.meshes.begin(), generated.meshes.end(),
                                    [&body](const GeneratedScene::Mesh& mesh) {
                                      return mesh.file == body.mesh.filename();
                                    });
    EXPECT_NE(found, generated.meshes.end());
    return found->mesh;
  }

  HandScript HandAt(std::size_t i) const {
    const Result<HandScript> script = LoadHandScript(scene.hands.at(i).file);
    EXPECT_TRUE(script) << script.error().what;
    return *script;
  }

  ScratchFolder folder;
  GeneratedScene generated;
  Scene scene;
  TriangleMesh fixed;
  TriangleMesh moving;
};

/// Puts a moving part's surface where a hand means it to be.
class PartOnItsWay {
 public:
  PartOnItsWay(const TriangleMesh& part, double spacing)
      : samples_(SurfaceSamples(part, spacing)), centre_(VolumeCentre(part)) {}

  template <typename Visit>
  void ForEachPoint(const Waypoint& at, const Visit& visit) const {
    for (const Vec3& p : samples_) visit(at.q_W * (p - centre_) + centre_ + at.p_W / kMm);
  }

 private:
  std::vector<Vec3> samples_;
  Vec3 centre_;
};

double LeastClearance(const PartOnItsWay& part, const SolidProbe& solid, const Waypoint& at) {
  double least = 1e300;
  part.ForEachPoint(at, [&](const Vec3& p) {
    const double distance = solid.Distance(p);
    least = std::min(least, solid.Inside(p) ? -distance : distance);
  });
  return least;
}

double Deepest(const PartOnItsWay& part, const SolidProbe& solid, const Waypoint& at) {
  double deepest = 0;
  part.ForEachPoint(at, [&](const Vec3& p) {
    if (solid.Inside(p)) deepest = std::max(deepest, solid.Distance(p));
  });
  return deepest;
}

struct NamedScene {
  const char* name;
  GeneratedScene (*make)();
};
void PrintTo(const NamedScene& scene, std::ostream* out) {
  *out << scene.name;
}
std::string NameOf(const ::testing::TestParamInfo<NamedScene>& info) {
  return info.param.name;
}

constexpr NamedScene kPegInSlot = {"PegInSlot", PegInSlot};
constexpr NamedScene kBallAndSocket = {"BallAndSocket", BallAndSocket};
constexpr NamedScene kBracketActuator = {"BracketActuator", BracketActuator};
constexpr NamedScene kNutAndBolt = {"NutAndBolt", NutAndBolt};

class Scenes : public ::testing::TestWithParam<NamedScene> {};

TEST_P(Scenes, LoadWithTheirFilesAndHands) {
  const LoadedScene loaded(GetParam().make());
  EXPECT_EQ(loaded.scene.name, loaded.generated.name);
  EXPECT_EQ(loaded.scene.hands.size(), 2U);
  for (std::size_t i = 0; i < loaded.scene.hands.size(); ++i) {
    const HandScript script = loaded.HandAt(i);
    // hands must rest by 60 % of a run of 18 s, and may be told to start 1.5 s late
    EXPECT_LE(script.duration(), 9.0);
    for (double t = 0; t < script.duration(); t += 0.01) {
      EXPECT_LT(script.IntendedTwistAt(t).v.norm(), 0.12) << t;
    }
  }
}

TEST_P(Scenes, HaveClosedBodiesOnly) {
  for (const GeneratedScene::Mesh& mesh : GetParam().make().meshes) {
    EXPECT_TRUE(ClosedAndTurnedOutward(mesh.mesh)) << mesh.file;
  }
}

// Readers weld by equal position: corners that differ must not fall together in single precision,
// or bodies that only touch would become one.
TEST_P(Scenes, CornersStayApartInSinglePrecision) {
  for (const GeneratedScene::Mesh& mesh : GetParam().make().meshes) {
    std::vector<std::array<float, 3>> corners;
    for (const Vec3& v : mesh.mesh.vertices) {
      corners.push_back(
          {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())});
    }
    std::sort(corners.begin(), corners.end());
    EXPECT_EQ(std::adjacent_find(corners.begin(), corners.end()), corners.end()) << mesh.file;
  }
}

TEST_P(Scenes, AreReproducibleByteForByte) {
  const ScratchFolder first;
  const ScratchFolder second;
  ASSERT_FALSE(WriteScene(GetParam().make(), first.path()));
  ASSERT_FALSE(WriteScene(GetParam().make(), second.path()));
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(first.path())) {
    EXPECT_EQ(Bytes(entry.path()), Bytes(second.path() / entry.path().filename())) << entry.path();
    ++files;
  }
  EXPECT_GE(files, 4U);
}

INSTANTIATE_TEST_SUITE_P(All, Scenes,
                         ::testing::Values(kPegInSlot, kBallAndSocket, kBracketActuator,
                                           kNutAndBolt),
                         NameOf);

/// Scenes whose part is to be brought out of its fixture.
class WayOut : public ::testing::TestWithParam<NamedScene> {};

TEST_P(WayOut, StartsFiveMillimetresClear) {
  const LoadedScene loaded(GetParam().make());
  const SolidProbe solid(loaded.fixed, 10);
  EXPECT_GT(LeastClearance(PartOnItsWay(loaded.moving, 1.5), solid, Waypoint{}), 5.0);
}

TEST_P(WayOut, IntendedPathCrossesSolidAndEndsOutside) {
  const LoadedScene loaded(GetParam().make());
  const SolidProbe solid(loaded.fixed, 10);
  const PartOnItsWay part(loaded.moving, 4.0);
  const double voxel_mm = loaded.scene.voxel_size / kMm;
  const Bounds fixture = BoundsOf(loaded.fixed);
  for (std::size_t i = 0; i < 2; ++i) {
    const HandScript script = loaded.HandAt(i);
    constexpr double kStep = 0.2;
    double deepest = 0;
    double overlapping = 0;  // s
    for (double t = 0; t <= script.duration(); t += kStep) {
      const double depth = Deepest(part, solid, script.IntentAt(t));
      deepest = std::max(deepest, depth);
      if (depth > 0) overlapping += kStep;
    }
    EXPECT_GE(deepest, 3 * voxel_mm);
    // a tenth and a half of a run of 20 s, most of which the hands rest
    EXPECT_GE(overlapping, 3.0);
    EXPECT_GE(overlapping, 0.1 * script.duration());

    Bounds at_last;
    part.ForEachPoint(script.waypoints.back(), [&](const Vec3& p) {
      at_last.Add(p);
    });
    EXPECT_GT(at_last.min.z(), fixture.max.z() + 10);
  }
}

TEST_P(WayOut, SecondHandFollowsTheFirstWithALag) {
  const LoadedScene loaded(GetParam().make());
  const HandScript first = loaded.HandAt(0);
  const HandScript second = loaded.HandAt(1);
  EXPECT_GT((first.X_BD.p - second.X_BD.p).norm(), 0.01);
  EXPECT_LT((first.waypoints.back().p_W - second.waypoints.back().p_W).norm(), 1e-6);
  double apart = 0;
  for (double t = 0; t < 9; t += 0.05) {
    apart = std::max(apart, (first.IntentAt(t).p_W - second.IntentAt(t).p_W).norm());
  }
  EXPECT_GT(apart, 0.004);
  EXPECT_LT(apart, 0.05);
}

INSTANTIATE_TEST_SUITE_P(All, WayOut, ::testing::Values(kPegInSlot, kBracketActuator), NameOf);

TEST(BallAndSocketScene, HasThePapersTriangles) {
  const GeneratedScene scene = BallAndSocket();
  EXPECT_EQ(scene.meshes[0].mesh.triangles.size(), 2176U);
  EXPECT_EQ(scene.meshes[1].mesh.triangles.size(), 2048U);
  EXPECT_NEAR(BoundsOf(scene.meshes[1].mesh).size().x(), 25.0, 1e-9);
}

TEST(BallAndSocketScene, BallFitsItsSocketWithoutClearance) {
  const GeneratedScene scene = BallAndSocket();
  const SolidProbe socket(scene.meshes[0].mesh, 2);
  double least = 1e300;
  for (const Vec3& p : scene.meshes[1].mesh.vertices) least = std::min(least, socket.Distance(p));
  EXPECT_NEAR(least, 0, 1e-9);
}

/// Returns where the nut is after so many turns along its thread.
Waypoint OnTheThread(double turns) {
  constexpr double kPitch = 5 * kMm;
  return {0, Vec3(0, 0, kPitch * turns), RotationBy(Vec3(0, 0, 2 * M_PI * turns))};
}

TEST(NutAndBoltScene, NutMovesAlongItsThreadOnly) {
  constexpr double kPlay = 0.15;  // mm, along the axis; less where flanks are of other facets
  const LoadedScene loaded(NutAndBolt());
  const SolidProbe solid(loaded.fixed, 1);
  const PartOnItsWay nut(loaded.moving, 0.5);
  for (const double turns : {-1.0, -0.63, -0.28, 0.0, 0.4, 1.1, 1.5}) {
    const Waypoint at = OnTheThread(turns);
    const double clear = LeastClearance(nut, solid, at);
    EXPECT_GT(clear, 0.7 * kPlay) << turns;
    EXPECT_LT(clear, 1.2 * kPlay) << turns;
    if (turns > 0) continue;  // the thread is lower where it begins
    for (const double off : {-2 * kPlay, 2 * kPlay}) {
      Waypoint beside = at;
      beside.p_W.z() += off * kMm;
      EXPECT_GT(Deepest(nut, solid, beside), 0.1) << turns << " " << off;
    }
  }
}

TEST(NutAndBoltScene, HandsScrewTheNutOnAndOff) {
  const LoadedScene loaded(NutAndBolt());
  const HandScript script = loaded.HandAt(0);
  double turned = 0;
  double least = 0;
  for (double t = 0; t < script.duration(); t += 0.01) {
    turned += 0.01 * script.IntendedTwistAt(t).w.z() / (2 * M_PI);
    least = std::min(least, turned);
  }
  EXPECT_NEAR(least, -1, 0.01);
  EXPECT_NEAR(turned, 5.0 / 3, 0.01);
}

class BracketActuatorScene : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    loaded_ = new LoadedScene(BracketActuator());
    solid_ = new SolidProbe(loaded_->fixed, 10);
  }
  static void TearDownTestSuite() {
    delete solid_;
    delete loaded_;
  }
  static inline LoadedScene* loaded_ = nullptr;
  static inline SolidProbe* solid_ = nullptr;
};

TEST_F(BracketActuatorScene, HasAHundredThousandStaticAndTenThousandMovingTriangles) {
  EXPECT_GE(loaded_->fixed.triangles.size(), 90000U);
  EXPECT_LE(loaded_->fixed.triangles.size(), 120000U);
  EXPECT_GE(loaded_->moving.triangles.size(), 8000U);
  EXPECT_LE(loaded_->moving.triangles.size(), 12000U);
  EXPECT_NEAR(BoundsOf(loaded_->fixed).size().x(), 700, 10);
}

// about one and a half points a voxel face, all of them tested every millisecond
TEST_F(BracketActuatorScene, ActuatorHasFewEnoughSurfacePoints) {
  double area = 0;
  for (std::size_t t = 0; t < loaded_->moving.triangles.size(); ++t) {
    const Vec3& a = loaded_->moving.corner(t, 0);
    area += 0.5 * (loaded_->moving.corner(t, 1) - a).cross(loaded_->moving.corner(t, 2) - a).norm();
  }
  EXPECT_LT(1.5 * area, 40000);
}

TEST_F(BracketActuatorScene, StraightWayOutCrossesAWebOfMoreThanEightMillimetres) {
  // up from the actuator's points: the longest unbroken stretch within solid
  double longest = 0;
  constexpr double kStep = 0.25;
  for (const Vec3& p : SurfaceSamples(loaded_->moving, 8)) {
    double stretch = 0;
    for (double z = p.z(); z < 200; z += kStep) {
      stretch = solid_->Inside({p.x(), p.y(), z}) ? stretch + kStep : 0;
      longest = std::max(longest, stretch);
    }
  }
  EXPECT_GE(longest, 8.0);
}

TEST_F(BracketActuatorScene, TurnAndSlideIsCollisionFree) {
  const PartOnItsWay part(loaded_->moving, 3.0);
  for (int degrees = 0; degrees <= 90; degrees += 10) {
    Waypoint turn;
    turn.q_W = RotationBy(Vec3(0, 0, degrees * M_PI / 180));
    EXPECT_GT(LeastClearance(part, *solid_, turn), 4.0) << degrees;
  }
  for (int rise = 0; rise <= 180; rise += 12) {
    Waypoint slide;
    slide.q_W = RotationBy(Vec3(0, 0, M_PI / 2));
    slide.p_W = Vec3(0, 0, rise * kMm);
    EXPECT_GT(LeastClearance(part, *solid_, slide), 4.0) << rise;
  }
}

TEST_F(BracketActuatorScene, SlidingWithoutTheTurnHitsTheWeb) {
  const PartOnItsWay part(loaded_->moving, 3.0);
  Waypoint slide;
  slide.p_W = Vec3(0, 0, 0.018);
  EXPECT_LT(LeastClearance(part, *solid_, slide), -3.0);
}

TEST(Generators, TakeOneFolderAndNoOptions) {
  const ScratchFolder folder;
  int exit_code = -1;
  const auto given = [&exit_code](std::vector<const char*> words) {
    words.insert(words.begin(), "generate");
    return FolderToFill(static_cast<int>(words.size()), words.data(), "generate", "writes",
                        exit_code);
  };
  EXPECT_EQ(given({folder.path().c_str()}), folder.path());
  for (const std::vector<const char*>& words :
       std::vector<std::vector<const char*>>{{},
                                             {""},
                                             {"--force"},
                                             {"-v"},
                                             {"--out=x"},
                                             {folder.path().c_str(), "--force"},
                                             {folder.path().c_str(), "more"},
                                             {"/nowhere/at/all"}}) {
    EXPECT_FALSE(given(words));
    EXPECT_EQ(exit_code, 2);
  }
  EXPECT_FALSE(given({"--help"}));
  EXPECT_EQ(exit_code, 0);
}

}  // namespace
}  // namespace tandem
