#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/network/control_fixture.h"
#include "tests/support/machine/processor_wait.h"
#include "tests/support/obj_text.h"

// Tests a host in this program and a controller in a process of its own.

namespace tandem {
namespace {

using std::chrono::milliseconds;

/// Names what is in a folder, for a message.
std::string NamesIn(const std::filesystem::path& folder) {
  std::string names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    names += entry.path().filename().string() + " ";
  }
  return names;
}

using ControlTest = testing::ControlTest;
using testing::HearUntil;

TEST_F(ControlTest, HostGrabsMovesSavesAndQuits) {
  Start();
  Controller host = Attach();
  ASSERT_EQ(host.snapshot().bodies.size(), 2U);
  EXPECT_FALSE(host.Ask(GrabRequest{.body = "hammer"}).ok);
  const Answer grabbed = host.Ask(GrabRequest{.body = "peg"});
  ASSERT_TRUE(grabbed.ok) << grabbed.reason;
  while (host.snapshot().hand.body < 0) host.Wait(milliseconds(100));
  const auto body = static_cast<std::size_t>(host.snapshot().hand.body);
  EXPECT_EQ(host.snapshot().bodies[body].name, "peg");
  PlainPose goal = host.snapshot().hand.X_WG;
  goal.p_W[2] += 0.005;
  host.SetGoal(goal);
  const auto risen_mm = [&] {
    return 1e3 * host.snapshot().bodies[body].X_W.p_W[2];
  };
  // it is there and at rest: the saved place and the place seen afterwards are the same
  double before_mm = 0;
  for (int i = 0;
       i < 500 && (std::abs(risen_mm() - 5.0) > 0.3 || std::abs(risen_mm() - before_mm) > 0.02);
       ++i) {
    before_mm = risen_mm();
    std::this_thread::sleep_for(milliseconds(100));
    host.Wait(milliseconds(20));
  }
  EXPECT_NEAR(risen_mm(), 5.0, 0.3);

  const std::string saved = (folder_.path() / "saved.json").string();
  Answer answer = host.Ask(SaveRequest{saved});
  EXPECT_TRUE(answer.ok) << answer.reason;
  EXPECT_FALSE(host.Ask(SaveRequest{saved}).ok) << "it exists already";
  answer = host.Ask(LoadSceneRequest{"/nowhere.json"});
  EXPECT_FALSE(answer.ok);
  EXPECT_NE(answer.reason.find("/nowhere.json"), std::string::npos) << answer.reason;
  // the scene as saved has the peg where it stands, as its first place
  const std::uint64_t number = host.snapshot().scene_number;
  const double z = host.snapshot().bodies[body].X_WB.p_W[2];
  answer = host.Ask(LoadSceneRequest{saved});
  ASSERT_TRUE(answer.ok) << answer.reason;
  EXPECT_TRUE(HearUntil(host, [&host, number] {
    return host.snapshot().scene_number != number && !host.snapshot().bodies.empty();
  }));
  ASSERT_EQ(host.snapshot().scene_number, number + 1);
  ASSERT_EQ(host.snapshot().bodies.size(), 2U);
  EXPECT_NEAR(host.snapshot().bodies[body].X_WB.p_W[2], z, 1e-3);
  EXPECT_EQ(host.snapshot().scene, saved);

  EXPECT_TRUE(host.Ask(QuitRequest{}).ok);
  EXPECT_EQ(controller_->Wait(std::chrono::minutes(1)), 0);
}

TEST_F(ControlTest, MeasuresHowNearThePartInHandIsToTheOthers) {
  Start();
  Controller host = Attach();
  EXPECT_EQ(host.snapshot().distance.m, -1);
  ASSERT_TRUE(host.Ask(MeasureDistancesRequest{}).ok);
  ASSERT_TRUE(host.Ask(GrabRequest{.body = "peg"}).ok);
  EXPECT_TRUE(HearUntil(host, [&host] {
    return host.snapshot().distance.m >= 0;
  }));
  const SnapshotDistance near = host.snapshot().distance;
  ASSERT_GT(near.m, 0);
  EXPECT_EQ(host.snapshot().bodies[static_cast<std::size_t>(near.other)].name, "block");
  double apart = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    apart += (near.p_W[i] - near.p_other_W[i]) * (near.p_W[i] - near.p_other_W[i]);
  }
  EXPECT_NEAR(std::sqrt(apart), near.m, near.error_m + 1e-9);
  EXPECT_LT(near.error_m, 1e-3) << "a voxel";
  ASSERT_GT(near.m, 2e-3);
  // pushed towards it, it comes to it
  PlainPose goal = host.snapshot().hand.X_WG;
  for (std::size_t i = 0; i < 3; ++i) {
    goal.p_W[i] += 2 * (near.p_other_W[i] - near.p_W[i]);
  }
  host.SetGoal(goal);
  EXPECT_TRUE(HearUntil(host, [&host] {
    return host.snapshot().distance.m < 1e-3;
  })) << host.snapshot().distance.m;
  ASSERT_TRUE(host.Ask(MeasureDistancesRequest{false}).ok);
}

// Libraries throw at these names of files and bodies.
TEST_F(ControlTest, SurvivesRequestsWithInvalidFiles) {
  Start();
  Controller host = Attach();
  const std::string endless(300, 'x');
  for (const ControlRequest& request : std::vector<ControlRequest>{
           LoadMeshRequest{}, LoadMeshRequest{"relative.obj", ""},
           LoadMeshRequest{"/" + endless, ""}, LoadSceneRequest{"/" + endless + ".json"},
           LoadSceneRequest{endless}, LoadSceneRequest{""}, SaveRequest{""},
           SaveRequest{"/" + endless}, SaveRequest{"/nowhere/at/all.json"},
           VoxelizeRequest{"/" + endless}, VoxelizeRequest{""}}) {
    const Answer answer = host.Ask(request);
    EXPECT_FALSE(answer.ok) << request.index();
    EXPECT_NE(answer.reason, "no answer in time") << request.index();
    EXPECT_FALSE(answer.reason.empty()) << request.index();
  }
  EXPECT_FALSE(controller_->Poll()) << "the controller has ended";
  EXPECT_TRUE(host.Ask(GrabRequest{.body = "peg"}).ok);
}

// Two hosts ask for two scenes at once: one scene comes, the other host is told.
TEST_F(ControlTest, AnswersConcurrentLoadsAndStopsDuringALoad) {
  Start();
  Controller host = Attach();
  std::vector<Answer> answers;
  const auto keep = [&answers](const Answer& answer) {
    answers.push_back(answer);
  };
  const std::string scene = std::string(TANDEM_SCENES) + "/peg_in_slot.json";
  for (int i = 0; i < 5; ++i) host.Send(LoadSceneRequest{scene}, keep);
  host.Send(EmergencyStopRequest{}, keep);
  HearUntil(host, [&answers] {
    return answers.size() == 6;
  });
  ASSERT_EQ(answers.size(), 6U);
  EXPECT_GE(std::ranges::count(answers, true, &Answer::ok), 2) << "a scene, and the stop";
  EXPECT_FALSE(host.Ask(GrabRequest{.body = "peg"}).ok) << "the stop outlives the scene";
  EXPECT_TRUE(host.Ask(ResumeRequest{}).ok);
  EXPECT_TRUE(HearUntil(host, [&host] {
    return !host.snapshot().bodies.empty();
  }));
  EXPECT_TRUE(host.Ask(GrabRequest{.body = "peg"}).ok);
}

// Voxels so small that they take long.
TEST_F(ControlTest, QuitsDuringVoxelization) {
  const std::string folder = std::string(TANDEM_SCENES) + "/";
  const std::string fine = (folder_.path() / "fine.json").string();
  std::ofstream(fine) << R"({"name": "fine", "voxel_m": 4e-5, "bodies": [
      {"name": "block", "mesh": ")"
                      << folder << R"(peg_in_slot_block.stl", "scale": 0.001, "fixed": true},
      {"name": "peg", "mesh": ")"
                      << folder << R"(peg_in_slot_peg.stl", "scale": 0.001, "mass_kg": 0.3}]})";
  Start();
  Controller host = Attach();
  bool answered = false;
  host.Send(LoadSceneRequest{fine}, [&](const Answer& answer) {
    answered = true;
    EXPECT_FALSE(answer.ok);
  });
  for (int i = 0; i < 10; ++i) host.Wait(milliseconds(100));
  EXPECT_FALSE(answered) << "it is not slow, or cannot be";
  // within three seconds in which it has a processor
  testing::ProcessorWait wait(controller_->pid());
  const auto begun = std::chrono::steady_clock::now();
  host.Send(QuitRequest{}, [](const Answer&) {});
  EXPECT_TRUE(HearUntil(host, [this, &wait] {
    wait.Look();
    return controller_->Poll().has_value();
  }));
  EXPECT_EQ(controller_->Poll(), 0);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begun;
  EXPECT_LT(took.count() - wait.Look(), 3);
}

// More requests than wait, at once: each has its answer.
TEST_F(ControlTest, AnswersEachOfManyRequests) {
  Start();
  Controller host = Attach();
  int answered = 0;
  int refused = 0;
  for (int i = 0; i < 300; ++i) {
    host.Send(SetParameterRequest{"hand_force_N", 5}, [&](const Answer& answer) {
      ++answered;
      refused += answer.ok ? 0 : 1;
    });
  }
  HearUntil(host, [&answered] {
    return answered == 300;
  });
  EXPECT_EQ(answered, 300);
  EXPECT_GT(refused, 0);
  EXPECT_LT(refused, 300);
}

TEST_F(ControlTest, RemovesItsFilesAndThoseOfKilledControllers) {
  Start();
  {
    // a scene of the controller's own, as it stands with one body more
    Controller host = Attach();
    const std::string mesh = (folder_.path() / "cube.obj").string();
    std::ofstream(mesh) << testing::BoxObjText(0.01, 0.01, 0.01);
    Answer loaded = host.Ask(LoadMeshRequest{.file = mesh, .body = "cube"});
    // it may not have seen where its bodies are yet
    for (int i = 0; i < 200 && loaded.reason == "the scene is being loaded"; ++i) {
      host.Wait(milliseconds(50));
      loaded = host.Ask(LoadMeshRequest{.file = mesh, .body = "cube"});
    }
    ASSERT_TRUE(loaded.ok) << loaded.reason;
  }
  controller_->Signal(SIGKILL);
  controller_->Wait(std::chrono::minutes(1));
  const std::filesystem::path folder = folder_.path() / "tandem";
  EXPECT_TRUE(std::filesystem::exists(folder / (name_ + ".lock")));
  EXPECT_GT(std::ranges::distance(std::filesystem::directory_iterator(folder)), 1);
  name_ += "-next";
  Start();
  EXPECT_TRUE(Attach().Ask(QuitRequest{}).ok);
  EXPECT_EQ(controller_->Wait(std::chrono::minutes(1)), 0);
  EXPECT_TRUE(std::filesystem::is_empty(folder)) << NamesIn(folder);
}

TEST_F(ControlTest, ControllerNamesAreUnique) {
  Start();
  Controller host = Attach();
  ChildProcess first = *std::move(controller_);
  Start();
  EXPECT_EQ(controller_->Wait(std::chrono::minutes(1)), 5);
  EXPECT_FALSE(first.Poll()) << "the first one goes on";
}

TEST_F(ControlTest, ReportsAMissingController) {
  Controller::Options options;
  options.timeout_s = 0.3;
  const Result<Controller> host = Controller::Attach("nobody", options);
  ASSERT_FALSE(host);
  EXPECT_NE(host.error().what.find("no controller 'nobody' on this machine"), std::string::npos);
}

}  // namespace
}  // namespace tandem
