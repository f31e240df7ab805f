#include "collab/lab/run/recorded_run.h"

#include <gmock/gmock.h>

#include "collab/lab/case/case_parts.h"
#include "collab/recording/recorder.h"
#include "collab/simulated/network/simulated_session.h"
#include "engine/haptics/scripted_device.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;

LabScene CubeInSpace() {
  auto model = std::make_shared<WorldModel>(
      *testing::MakeWorldModel({{testing::Box(Vec3(0.04, 0.04, 0.04))}}, 0.002));
  model->scene.bodies[0].shared = true;
  return {model, 0};
}

LabCase Move(const LabScene& scene) {
  LabCase test;
  test.motion = LabMotion::kMove;
  test.hands = {*HandNamed("relaxed", scene.inertia())};
  test.delay_s = 0.05;
  test.seconds = 6;
  return test;
}

// Records peers as they are live, in virtual time, each with a recorder.
std::vector<std::filesystem::path> Record(const LabCase& test, const LabScene& scene,
                                          const std::filesystem::path& folder, int frames) {
  SimulatedSession session;
  std::vector<std::unique_ptr<Recorder>> recorders;
  std::vector<std::filesystem::path> files;
  for (std::size_t user = 0; user < test.users; ++user) {
    NodeOptions options;
    options.peer.id = 1 + user;
    options.peer.held_object = 0;
    options.peer.wait_for = test.users - 1;
    options.conditions = ConditionsOf(test, 1 - user, user, test.delay_s);
    files.push_back(folder / std::to_string(user));
    RecordingHeader header;
    header.law = test.law.name;
    header.peer = options.peer;
    recorders.push_back(*Recorder::Create(files.back(), header));
    options.peer.observer = recorders.back().get();
    auto device = std::make_unique<ScriptedDevice>(ScriptOf(test, user), Pose{});
    session.Add(std::make_unique<PeerNode>(scene.model, std::move(device), 42, options), 1 + user);
  }
  for (int frame = 0; frame < frames; ++frame) session.Step();
  for (const auto& recorder : recorders) EXPECT_TRUE(recorder->Close().has_value());
  return files;
}

// A recording gives the same measures as the peers themselves.
TEST(RecordedRun, MatchesARunInVirtualTime) {
  const ScratchFolder scratch;
  const LabScene scene = CubeInSpace();
  const LabCase test = Move(scene);
  const auto files = Record(test, scene, scratch.path(), 8000);
  const Result<RecordedRun> recorded = MeterRecordings(files, test, scene);
  ASSERT_TRUE(recorded) << recorded.error().what;
  const CaseResult simulated = RunCase(test, scene);
  ASSERT_FALSE(simulated.fault);
  const Metrics& ours = recorded->metrics;
  const Metrics& theirs = simulated.metrics;
  EXPECT_GT(theirs.peak_apart, 0.02);
  EXPECT_NEAR(ours.peak_apart, theirs.peak_apart, 0.02 * theirs.peak_apart);
  EXPECT_NEAR(ours.peak_force, theirs.peak_force, 0.02 * theirs.peak_force);
  EXPECT_NEAR(ours.stiffness, theirs.stiffness, 0.02 * theirs.stiffness);
  EXPECT_NEAR(ours.loop_age_s, theirs.loop_age_s, 0.002);
  EXPECT_EQ(ours.frames, theirs.frames);
  EXPECT_EQ(recorded->verdict, simulated.verdict);
}

TEST(RecordedRun, TooShortRecordingIsNamed) {
  const ScratchFolder scratch;
  const LabScene scene = CubeInSpace();
  const LabCase test = Move(scene);
  const auto files = Record(test, scene, scratch.path(), 3000);
  const Result<RecordedRun> recorded = MeterRecordings(files, test, scene);
  ASSERT_FALSE(recorded);
  EXPECT_THAT(recorded.error().what, HasSubstr("the case takes 6"));
}

}  // namespace
}  // namespace tandem
