#include "app/view/model/proximity/proximity_model.h"

#include <gtest/gtest.h>

#include "tests/app/view/fake_session.h"
#include "tests/app/view/shapes.h"

namespace tandem {
namespace {

std::vector<Pose> BallMovedBy(double y) {
  std::vector<Pose> X_W(2);
  X_W[1].p.y() = y;
  return X_W;
}

class ProximityOfAScene : public ::testing::Test {
 protected:
  bool Shows(double distance) {
    return ProcessEventsUntil([&] {
      return model_.picture() != nullptr &&
             std::abs(model_.picture()->nearest.distance - distance) < 1e-6;
    });
  }
  std::shared_ptr<const DrawnScene> scene_ = std::make_shared<const DrawnScene>(BlockAndBall());
  ProximityModel model_;
};

TEST_F(ProximityOfAScene, IsIdleUntilSwitchedOn) {
  model_.SetScene(scene_);
  model_.SetPoses(BallMovedBy(0));
  QCoreApplication::processEvents();
  EXPECT_EQ(model_.state(), ProximityModel::State::kOff);
  EXPECT_EQ(scene_.use_count(), 2);  // no thread works on it
  EXPECT_TRUE(model_.message().isEmpty());
}

TEST_F(ProximityOfAScene, ReportsVoxelizationThenAnswersTheNewestPoses) {
  std::vector<QString> output;
  QObject::connect(&model_, &ProximityModel::Changed, [&] {
    if (output.empty() || output.back() != model_.message()) output.push_back(model_.message());
  });
  model_.SetScene(scene_);
  model_.SetPoses(BallMovedBy(0));
  model_.SwitchOn(true);
  EXPECT_EQ(model_.state(), ProximityModel::State::kVoxelizing);
  EXPECT_EQ(model_.picture(), nullptr);
  ASSERT_TRUE(Shows(0.05));
  EXPECT_EQ(model_.state(), ProximityModel::State::kOn);
  const std::vector<QString> expected{"Voxelizing", "Voxelizing block (1 of 2)",
                                      "Voxelizing ball (2 of 2)",
                                      "ball \u2013 block: 50.000 mm \u00b1 0.001 mm"};
  EXPECT_EQ(output, expected);
  for (int i = 1; i <= 40; ++i) model_.SetPoses(BallMovedBy(0.001 * i));
  EXPECT_TRUE(Shows(0.010));
}

TEST_F(ProximityOfAScene, AnswersEachPoseOnce) {
  model_.SetScene(scene_);
  model_.SetPoses(BallMovedBy(0));
  model_.SwitchOn(true);
  ASSERT_TRUE(Shows(0.05));
  const std::shared_ptr<const ProximityPicture> first = model_.picture();
  for (int i = 0; i < 10; ++i) {
    model_.SetPoses(BallMovedBy(0));
    QCoreApplication::processEvents(QEventLoop::AllEvents, 10);
  }
  EXPECT_EQ(model_.picture(), first);
}

TEST_F(ProximityOfAScene, IsImmediateWhenSwitchedOnAgain) {
  model_.SetScene(scene_);
  model_.SetPoses(BallMovedBy(0));
  model_.SwitchOn(true);
  ASSERT_TRUE(Shows(0.05));
  model_.SwitchOn(false);
  EXPECT_EQ(model_.picture(), nullptr);
  EXPECT_EQ(model_.state(), ProximityModel::State::kOff);
  bool voxelized = false;
  QObject::connect(&model_, &ProximityModel::Changed, [&] {
    voxelized = voxelized || model_.message().contains("1 of 2");
  });
  model_.SetPoses(BallMovedBy(0.02));
  model_.SwitchOn(true);
  ASSERT_TRUE(Shows(0.03));
  EXPECT_FALSE(voxelized);
}

TEST_F(ProximityOfAScene, FollowsSceneChanges) {
  DrawnScene other = BlockAndBall();
  other.bodies[0].name = "wall";
  model_.SetScene(scene_);
  model_.SwitchOn(true);
  model_.SetScene(std::make_shared<const DrawnScene>(other));
  model_.SetPoses(BallMovedBy(0.01));
  ASSERT_TRUE(Shows(0.04));
  EXPECT_EQ(model_.picture()->other, "wall");
  model_.SetScene(nullptr);
  EXPECT_EQ(model_.picture(), nullptr);
  EXPECT_EQ(model_.state(), ProximityModel::State::kNoScene);
}

TEST_F(ProximityOfAScene, ReportsWhyVoxelizationFails) {
  DrawnScene fine = BlockAndBall();
  fine.voxel_size = 1e-7;
  model_.SetScene(std::make_shared<const DrawnScene>(fine));
  model_.SwitchOn(true);
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return model_.state() == ProximityModel::State::kFailed;
  }));
  EXPECT_TRUE(model_.message().contains("block"));
  EXPECT_TRUE(model_.message().contains("GiB"));
  model_.SetScene(scene_);
  EXPECT_TRUE(Shows(0.05));
}

TEST(ProximityModel, CanBeDestroyedDuringVoxelization) {
  const auto scene = std::make_shared<const DrawnScene>(BlockAndBall());
  {
    ProximityModel model;
    model.SetScene(scene);
    model.SwitchOn(true);
  }
  QCoreApplication::processEvents();
  EXPECT_EQ(scene.use_count(), 1);
}

}  // namespace
}  // namespace tandem
