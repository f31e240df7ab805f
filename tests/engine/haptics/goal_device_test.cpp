#include "engine/haptics/goal_device.h"

#include <memory>

#include <gtest/gtest.h>

namespace tandem {
namespace {

/// A device that is told of parts as a peer tells it.
class GoalDeviceTest : public ::testing::Test {
 protected:
  void Order(int body, bool keeps_way = false) {
    ++order_.grasp_seq;
    order_.body = body;
    order_.keeps_way = keeps_way;
    Publish();
  }
  void Way(GoalOrder::Way way) {
    ++order_.way_seq;
    order_.way = way;
    Publish();
  }
  /// Runs frames with that part in hand; -1: with none.
  void Hold(int body, double x = 0) {
    PartInHand part;
    part.wanted = body;
    part.attached = body >= 0;
    part.state.X_WB.p.x() = x;
    part.radius = 0.02;
    for (int i = 0; i < 3; ++i) device_.See(part);
  }
  /// Means a pose 0.1 m to the side, or a rate that way.
  void Mean(GoalOrder::Input input) {
    ++order_.input_seq;
    order_.input = input;
    order_.X_WG.p = Vec3(0, 0.1, 0);
    order_.linear = Vec3(0, 0.1, 0);
    Publish();
  }
  /// Asks for a part: what has been said until now is of before.
  void AskFor(int body) {
    order_.void_seq = order_.input_seq;
    order_.body = body;
  }
  /// Returns the hand's goal after so many frames with that part in it.
  double GoalAfter(int frames) {
    PartInHand part;
    part.wanted = 0;
    part.attached = false;
    device_.See(part);
    part.attached = true;
    for (int i = 0; i < frames; ++i) {
      device_.See(part);
      device_.Read();
    }
    return device_.requested().p.y();
  }
  const PathBacktracker& way() const { return device_.way(); }

 private:
  void Publish() {
    orders_->newest.back() = order_;
    orders_->newest.Publish();
  }
  GoalOrder order_;
  std::shared_ptr<GoalDevice::Orders> orders_ = std::make_shared<GoalDevice::Orders>();
  GoalDevice device_{orders_};
};

TEST_F(GoalDeviceTest, OrdersBeforeTheGrabAreIgnored) {
  for (const auto input : {GoalOrder::Input::kPose, GoalOrder::Input::kRate}) {
    Mean(input);
    AskFor(0);
    Order(0);
    EXPECT_EQ(GoalAfter(50), 0.0);
    Hold(-1);
  }
}

TEST_F(GoalDeviceTest, OrdersDuringTheGrabCount) {
  AskFor(0);
  Mean(GoalOrder::Input::kPose);
  Order(0);
  EXPECT_EQ(GoalAfter(50), 0.1);
  Hold(-1);
  AskFor(0);
  Mean(GoalOrder::Input::kRate);
  Order(0);
  EXPECT_NEAR(GoalAfter(50), 50 * 1e-4, 2e-4) << "0.1 m/s";
}

TEST_F(GoalDeviceTest, ImmediatelyExchangedPartStartsANewPath) {
  Order(0);
  Hold(0);
  Hold(1);
  EXPECT_EQ(way().body(), 1);
  Way(GoalOrder::Way::kDrop);
  Hold(-1);
  EXPECT_EQ(way().body(), 0);
}

TEST_F(GoalDeviceTest, UnrequestedPartStartsANewPath) {
  Order(0);
  Hold(0);
  Hold(-1);
  Order(1);
  Hold(1);
  Hold(-1);
  Order(1, true);  // undo
  Hold(1);
  Way(GoalOrder::Way::kDrop);
  Hold(-1);
  ASSERT_EQ(way().body(), 0);
  // another user puts it into the hand
  Hold(1, 0.3);
  EXPECT_EQ(way().body(), 1);
}

}  // namespace
}  // namespace tandem
