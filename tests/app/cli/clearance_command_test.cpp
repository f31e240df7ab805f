#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/common/exit_codes.h"
#include "collab/recording/recorder.h"
#include "collab/recording/replay.h"
#include "collab/simulated/network/simulated_session.h"
#include "engine/haptics/scripted_device.h"
#include "engine/scene/scene_hash.h"
#include "tests/app/cli/program_run.h"
#include "tests/support/key_scene.h"
#include "tests/support/shapes.h"

// Tests what `tandem clearance` tells of recordings of one hand. The recordings are made in virtual
// time.

namespace tandem {
namespace {

using nlohmann::json;
using testing::BoxBetween;
using testing::BoxOfHalf;
using testing::ExpectRefused;
using ::testing::HasSubstr;
using testing::ObjText;
using testing::ProgramOutput;
using testing::RunTandem;

constexpr double kMillimetre = 1e-3;
constexpr double kSceneVoxel = 1e-3;  // m; voxel of the scenes with a block

struct HandOfRecording {
  std::string body;          // body in the hand; empty: it holds nothing
  Vec3 to_W = Vec3::Zero();  // m; displacement from the first place
  double seconds = 2;        // duration of the way; then the hand stays half a second
  bool contact = true;
  double displaced = 0;  // m; outward displacement, ordered in the second frame
};

/// A function that is shown the recorded peer's world after each frame.
using SeesWorld = std::function<void(const World&)>;

/// Returns the header that every peer of a recorded session has.
RecordingHeader HeaderFor(const Scene& scene, const std::string& scene_file, PeerId id,
                          const HandOfRecording& hand) {
  RecordingHeader header;
  header.program = "test";
  header.name = "peer " + std::to_string(id);
  header.scene = scene_file;
  header.scene_hash = HashScene(scene)->content;
  header.parameters = ParametersOf(scene);
  header.peer.experiments.contact = hand.contact;
  header.law = "p+d";
  header.peer.id = id;
  header.peer.held_object = hand.body.empty() ? -1 : scene.BodyNamed(hand.body);
  return header;
}

std::unique_ptr<PeerNode> NodeFor(const std::shared_ptr<const WorldModel>& model,
                                  const RecordingHeader& header, const HandOfRecording& hand,
                                  FrameObserver* observer) {
  HandScript script;
  script.waypoints = {{0, Vec3::Zero(), Quat::Identity()},
                      {hand.seconds, hand.to_W, Quat::Identity()}};
  const auto body = static_cast<std::size_t>(std::max(0, model->BodyNamed(hand.body)));
  NodeOptions options;
  options.peer = header.peer;
  options.peer.law = *MakeLaw(header.law, header.limits, true);
  options.peer.observer = observer;
  options.name = header.name;
  auto node = std::make_unique<PeerNode>(
      model, std::make_unique<ScriptedDevice>(script, model->bodies[body].X_WB0), header.scene_hash,
      options);
  return node;
}

/// Records the first of these hands into a file. The session has a peer for each hand.
void RecordHands(const std::string& scene_file, const std::vector<HandOfRecording>& hands,
                 const std::filesystem::path& file, const SeesWorld& sees = {}) {
  const Result<Scene> scene = LoadScene(scene_file);
  ASSERT_TRUE(scene) << scene.error().what;
  const Result<std::shared_ptr<const WorldModel>> model = LoadWorld(*scene);
  ASSERT_TRUE(model) << model.error().what;
  std::unique_ptr<Recorder> recorder;
  SimulatedSession session;
  for (const HandOfRecording& hand : hands) {
    const PeerId id = 1 + session.size();
    RecordingHeader header = HeaderFor(*scene, scene_file, id, hand);
    header.device = ScriptedDevice({}, {}).capabilities();
    if (!recorder) {
      Result<std::unique_ptr<Recorder>> made = Recorder::Create(file, header);
      ASSERT_TRUE(made) << made.error().what;
      recorder = *std::move(made);
      session.Add(NodeFor(*model, header, hand, recorder.get()), id);
    } else {
      session.Add(NodeFor(*model, header, hand, nullptr), id);
    }
  }
  const int frames = static_cast<int>(1000 * (hands[0].seconds + 0.5));
  for (int i = 0; i < frames; ++i) {
    if (i == 1 && hands[0].displaced > 0) {
      session.node(0).peer().commands().TryPush(
          {.kind = Command::Kind::kDisplace, .metres = -hands[0].displaced});
    }
    session.Step();
    if (sees) sees(session.node(0).world());
  }
  ASSERT_TRUE(recorder->Close());
}

class ClearanceCommand : public ::testing::Test {
 protected:
  ClearanceCommand() { kHapticThread.Enter(); }

  std::string File(const char* name) const { return (folder_.path() / name).string(); }

  /// Returns what the command tells of the first of these hands in a scene.
  json Measured(const std::string& scene_file, const std::vector<HandOfRecording>& hands,
                const SeesWorld& sees = {}) {
    RecordHands(scene_file, hands, File("run"), sees);
    const ProgramOutput output = RunTandem("clearance --json " + File("run"), "timeout 200 ");
    EXPECT_EQ(output.exit_code, kExitOk) << output.err;
    json result = json::parse(output.out, nullptr, false);
    EXPECT_TRUE(result.is_object()) << output.out;
    return result;
  }

  /// Writes a scene of a 20 mm cube about the origin and another body, fixed or not. Returns its
  /// path.
  std::string CubeBeside(const TriangleMesh& other_W, bool fixed = true) {
    folder_.Write("cube.obj", ObjText(BoxOfHalf(Vec3::Constant(10 * kMillimetre))));
    folder_.Write("other.obj", ObjText(other_W));
    return folder_
        .Write("cube.json", std::string(R"({"name": "cube", "voxel_m": 0.001, "bodies": [
      {"name": "other", "mesh": "other.obj", )") +
                                (fixed ? R"("fixed": true)" : R"("mass_kg": 0.5)") + R"(},
      {"name": "cube", "mesh": "cube.obj", "mass_kg": 0.2}]})")
        .string();
  }

  ScratchFolder folder_;
};

// A key in the middle of its hole is as far from each wall as its play, and no path keeps more.
// Surfaces may come 0.05 voxel nearer than a clearance.
TEST_F(ClearanceCommand, KeyPassesWithItsPlayAndNoMore) {
  constexpr double kVoxelMm = 0.5;
  for (const double play_mm : {0.1, 0.2}) {
    const ScratchFolder key;
    const std::string scene =
        testing::WriteKeyScene(key, play_mm * kMillimetre, kVoxelMm * kMillimetre);
    const json room = Measured(scene, {{.body = "key", .to_W = Vec3(0, 0, 60 * kMillimetre)}});
    std::filesystem::remove(File("run"));
    EXPECT_EQ(room.at("body"), "key");
    EXPECT_EQ(room.at("other"), "hole");
    EXPECT_EQ(room.at("crosses"), false);
    EXPECT_LE(room.at("along_path_mm").get<double>(), play_mm + 1e-6);
    EXPECT_GE(room.at("along_path_mm").get<double>(), 0.9 * play_mm);
    // the place is between a side of the key and the wall beside it
    const double x = std::abs(room.at("p_W")[0].get<double>()) / kMillimetre;
    const double y = std::abs(room.at("p_W")[1].get<double>()) / kMillimetre;
    EXPECT_TRUE((x > 4 - 0.01 && x < 4.01 + play_mm) || (y > 3.5 - 0.01 && y < 3.51 + play_mm))
        << room;
    EXPECT_LE(room.at("passes_with_mm").get<double>(), play_mm + 0.05 * kVoxelMm);
    EXPECT_GE(room.at("passes_with_mm").get<double>(), play_mm);
    EXPECT_GE(room.at("kept_mm").get<double>(),
              room.at("passes_with_mm").get<double>() - 0.05 * kVoxelMm);
    EXPECT_EQ(room.at("at_least"), false);
  }
}

// The edge of a wall, turned by 45 degrees, points at the face of a cube that goes by. The cube
// begins and ends 40 mm beside it.
TEST_F(ClearanceCommand, PartPassingAnEdgeHasItsLateralDistance) {
  constexpr double kApartMm = 3;
  const double half = 10 * kMillimetre;
  const double to_edge = half * std::sqrt(2.0);  // distance of the edge from the wall's middle
  const TriangleMesh wall =
      Transformed(BoxOfHalf({half, half, 30 * kMillimetre}),
                  {RotationBy(Vec3(0, 0, M_PI / 4)),
                   Vec3(40 * kMillimetre, 10 * kMillimetre + kApartMm * kMillimetre + to_edge, 0)});
  const json room =
      Measured(CubeBeside(wall), {{.body = "cube", .to_W = Vec3(80 * kMillimetre, 0, 0)}});
  EXPECT_NEAR(room.at("along_path_mm").get<double>(), kApartMm, 1e-4);
  EXPECT_NEAR(room.at("p_W")[0].get<double>(), 40 * kMillimetre, 1e-6);
  EXPECT_NEAR(room.at("p_W")[1].get<double>(), (10 + 0.5 * kApartMm) * kMillimetre, 1e-6);
  // the face stands before the edge from 30 to 50 mm of 80: the middle of the two seconds
  EXPECT_GT(room.at("at_s").get<double>(), 0.5);
  EXPECT_LT(room.at("at_s").get<double>(), 1.5);
  // displacements end at a voxel
  EXPECT_EQ(room.at("at_least"), true);
  EXPECT_NEAR(room.at("passes_with_mm").get<double>(), 1e3 * kSceneVoxel, 1e-9);
}

// The hand uses 0.3 of the one voxel by which points can be displaced.
TEST_F(ClearanceCommand, RecordedClearanceOrdersAreEnlarged) {
  const TriangleMesh wall = BoxBetween({13 * kMillimetre, -30 * kMillimetre, -30 * kMillimetre},
                                       {20 * kMillimetre, 30 * kMillimetre, 0});
  const json room = Measured(CubeBeside(wall), {{.body = "cube",
                                                 .to_W = Vec3(0, 0, 40 * kMillimetre),
                                                 .seconds = 1,
                                                 .displaced = 0.3 * kSceneVoxel}});
  EXPECT_NEAR(room.at("along_path_mm").get<double>(), 3, 1e-4);
  EXPECT_EQ(room.at("at_least"), true);
  EXPECT_NEAR(room.at("passes_with_mm").get<double>(), 0.7e3 * kSceneVoxel, 1e-9);
}

// The block is half a voxel beside the way of the cube, which starts away from it. Refined contact
// begins 0.45 voxel away, so the recorded path is straight. A hand with more clearance is pushed
// aside.
TEST_F(ClearanceCommand, DeflectedHandPassesWithMoreThanThePathsClearance) {
  const TriangleMesh wall = BoxBetween({10.5 * kMillimetre, -30 * kMillimetre, 30 * kMillimetre},
                                       {20 * kMillimetre, 30 * kMillimetre, 0.05});
  const json room = Measured(
      CubeBeside(wall), {{.body = "cube", .to_W = Vec3(0, 0, 100 * kMillimetre), .seconds = 3}});
  EXPECT_NEAR(room.at("along_path_mm").get<double>(), 0.5, 1e-4);
  EXPECT_GT(room.at("passes_with_mm").get<double>(), 0.5 + 0.05);
  EXPECT_GE(room.at("kept_mm").get<double>(), room.at("passes_with_mm").get<double>() - 0.05);
}

TEST_F(ClearanceCommand, WithoutFixedBodiesThePartMustReachItsEndPose) {
  const TriangleMesh other = BoxBetween({13 * kMillimetre, -30 * kMillimetre, -30 * kMillimetre},
                                        {20 * kMillimetre, 30 * kMillimetre, 0});
  const json room =
      Measured(CubeBeside(other, false),
               {{.body = "cube", .to_W = Vec3(0, 0, 40 * kMillimetre), .seconds = 1}});
  EXPECT_EQ(room.at("other"), "other");
  EXPECT_NEAR(room.at("along_path_mm").get<double>(), 3, 1e-4);
  EXPECT_EQ(room.at("at_least"), true);
}

// The rim of a hole holds a key that comes from above at the distance at which contact begins: 0.45
// voxel and the clearance. With a play of 0.6 voxel the key goes in freely up to a clearance of
// 0.15. A firm hand presses it in at some more, but not at the 0.65 that the distances along the
// way allow.
TEST_F(ClearanceCommand, KeyBlockedByTheRimDoesNotPass) {
  constexpr double kVoxelMm = 0.5;
  folder_.Write("hole.obj", ObjText(testing::KeyholeMesh(0.6 * kVoxelMm * kMillimetre)));
  folder_.Write("key.obj", ObjText(testing::KeyMesh()));
  const std::string scene = folder_
                                .Write("in.json", R"({"name": "in", "voxel_m": 0.0005, "bodies": [
      {"name": "hole", "mesh": "hole.obj", "fixed": true},
      {"name": "key", "mesh": "key.obj", "mass_kg": 0.1, "pose": {"p_W": [0, 0, 0.012]}}]})")
                                .string();
  const json room = Measured(scene, {{.body = "key", .to_W = Vec3(0, 0, -10 * kMillimetre)}});
  EXPECT_NEAR(room.at("along_path_mm").get<double>(), 0.6 * kVoxelMm, 0.01 * kVoxelMm);
  // the clearance is bisected to 0.01 voxel, and beside edges the field may be 0.025 voxel low
  EXPECT_GE(room.at("passes_with_mm").get<double>(), (0.15 - 0.01 - 0.025) * kVoxelMm);
  EXPECT_LT(room.at("passes_with_mm").get<double>(), 0.6 * kVoxelMm);
}

// Another hand brings its body, which begins 8 mm beside the cube, nearer by 5 mm. The faces of the
// two are across x, so their gap is what the recording peer has between their origins, less the
// halves: 10 mm of the cube, 3.5 mm of the other.
TEST_F(ClearanceCommand, CountsABodyMovedByAnotherHand) {
  const TriangleMesh other = BoxBetween({18 * kMillimetre, -30 * kMillimetre, -30 * kMillimetre},
                                        {25 * kMillimetre, 30 * kMillimetre, 30 * kMillimetre});
  double gap = 1;
  const json room =
      Measured(CubeBeside(other, false),
               {{.body = "cube"}, {.body = "other", .to_W = Vec3(-5 * kMillimetre, 0, 0)}},
               [&](const World& world) {
                 const auto cube = static_cast<std::size_t>(world.model().BodyNamed("cube"));
                 const auto beside = static_cast<std::size_t>(world.model().BodyNamed("other"));
                 gap = std::min(gap, world.state(beside).X_WB.p.x() - world.state(cube).X_WB.p.x() -
                                         13.5 * kMillimetre);
               });
  ASSERT_LT(gap, 4 * kMillimetre) << "it came";
  EXPECT_EQ(room.at("body"), "cube");
  EXPECT_EQ(room.at("other"), "other");
  EXPECT_NEAR(room.at("along_path_mm").get<double>(), gap / kMillimetre, 1e-4);
}

// Without contact the hand brings a cube, whose lowest face is 10 mm below its origin, into a plate
// whose top is at -30 mm.
TEST_F(ClearanceCommand, PathThroughABodyHasNegativeClearance) {
  const TriangleMesh plate = BoxBetween({-60 * kMillimetre, -60 * kMillimetre, -80 * kMillimetre},
                                        {60 * kMillimetre, 60 * kMillimetre, -30 * kMillimetre});
  double lowest_z = 0;
  const json room = Measured(
      CubeBeside(plate),
      {{.body = "cube", .to_W = Vec3(0, 0, -22 * kMillimetre), .seconds = 1, .contact = false}},
      [&](const World& world) {
        lowest_z = std::min(lowest_z, world.state(0).X_WB.p.z());
      });
  ASSERT_LT(lowest_z, -21 * kMillimetre);
  EXPECT_EQ(room.at("crosses"), true);
  EXPECT_NEAR(room.at("along_path_mm").get<double>(), (lowest_z + 20 * kMillimetre) / kMillimetre,
              1e-6);
  EXPECT_NEAR(room.at("p_W")[2].get<double>(), lowest_z - 10 * kMillimetre, 1e-9);
  EXPECT_TRUE(room.at("passes_with_mm").is_null());
  EXPECT_TRUE(room.at("pressed_mm").is_null()) << "there was no contact";
}

// A cube between the ends of two pins, with play of 0.01 voxel: a hand that draws it aside presses
// it onto one of them. That is less than contact gives, and the voxel that decides gives half of
// it.
TEST_F(ClearanceCommand, TellsADepthThatContactGives) {
  constexpr double kEnd = 10.01 * kMillimetre;
  constexpr double kHalf = 0.3 * kMillimetre;
  TriangleMesh pins = BoxBetween({kEnd, -kHalf, -kHalf}, {kEnd + 10 * kMillimetre, kHalf, kHalf});
  Append(pins, BoxBetween({-kEnd - 10 * kMillimetre, -kHalf, -kHalf}, {-kEnd, kHalf, kHalf}));
  const json room = Measured(
      CubeBeside(pins), {{.body = "cube", .to_W = Vec3(40 * kMillimetre, 0, 0), .seconds = 1}});
  ASSERT_EQ(room.at("crosses"), true) << room;
  const double depth_mm = -room.at("along_path_mm").get<double>();
  const double pressed_mm = room.at("pressed_mm").get<double>();
  EXPECT_NEAR(pressed_mm, 0.208, 0.001);  // at voxels of a millimetre
  EXPECT_LT(depth_mm, pressed_mm);
  EXPECT_GE(room.at("depth_tolerance_mm").get<double>(), 0);
  EXPECT_LE(room.at("depth_tolerance_mm").get<double>(), 0.02);
  const double decides = 1e-3 * 0.5 * depth_mm / pressed_mm;
  EXPECT_LE(room.at("voxel_m_decides").get<double>(), decides * (1 + 1e-6));
  EXPECT_GE(room.at("voxel_m_decides").get<double>(), 0.9 * decides);
}

TEST_F(ClearanceCommand, PrintsBothFiguresAsText) {
  const TriangleMesh wall = BoxBetween({13 * kMillimetre, -30 * kMillimetre, -30 * kMillimetre},
                                       {20 * kMillimetre, 30 * kMillimetre, 0});
  RecordHands(CubeBeside(wall),
              {{.body = "cube", .to_W = Vec3(0, 0, 40 * kMillimetre), .seconds = 1}}, File("run"));
  const ProgramOutput output = RunTandem("clearance " + File("run"), "timeout 60 ");
  EXPECT_EQ(output.exit_code, kExitOk) << output.err;
  EXPECT_THAT(output.out, HasSubstr("cube-other: 3 mm is the least distance, "));
  EXPECT_THAT(output.out, HasSubstr("the same hand passes with a clearance of at least 1 mm, "));
}

TEST_F(ClearanceCommand, IncompleteRecordingIsRefusedInOneLine) {
  const TriangleMesh wall = BoxBetween({13 * kMillimetre, -30 * kMillimetre, -30 * kMillimetre},
                                       {20 * kMillimetre, 30 * kMillimetre, 0});
  const std::string scene = CubeBeside(wall);
  ExpectRefused(RunTandem("clearance /nowhere"), kExitFile, "/nowhere: there is no such file");
  ExpectRefused(RunTandem("clearance " + scene), kExitFile, "is not a recording");
  EXPECT_EQ(RunTandem("clearance").exit_code, kExitUsage);

  RecordHands(scene, {{.body = "", .seconds = 0.1}}, File("idle"));
  ExpectRefused(RunTandem("clearance " + File("idle")), kExitFailed, "the hand held no body");
  RecordHands(scene, {{.body = "cube", .to_W = Vec3(0, 0, 1 * kMillimetre), .seconds = 0.1}},
              File("run"));
  ExpectRefused(RunTandem("clearance --scene /nowhere.json " + File("run")), kExitFile,
                "/nowhere.json");
  const auto middle = static_cast<std::streamoff>(std::filesystem::file_size(File("run")) / 2);
  std::fstream stream(File("run"), std::ios::binary | std::ios::in | std::ios::out);
  stream.seekg(middle);
  const int before = stream.get();
  stream.seekp(middle);
  stream.put(static_cast<char>(before ^ 1));
  stream.close();
  ExpectRefused(RunTandem("clearance " + File("run")), kExitFailed, "damaged at frame ");
}

}  // namespace
}  // namespace tandem
