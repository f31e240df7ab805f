// The driver `keyboard` against a pipe of input events. Faults that are injected: repetitions
// (KeyRepeatIsIgnored), events that were lost (LostEventsLeaveNothingPressed), unplugged with keys
// down and plugged in again (AnUnpluggedKeyboardStandsStill).
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/app/device/driver_trial.h"
#include "tests/app/device/drivers/event_file.h"
#include "tests/support/scratch_folder.h"

namespace tandem::testing {
namespace {

using ::testing::HasSubstr;

class KeyboardTest : public ::testing::Test {
 protected:
  KeyboardTest() : file_(folder_.path() / "event3"), trial_("keyboard") {}
  void Begin(const std::string& options = "") {
    const std::string path = "path=" + (folder_.path() / "event3").string();
    ASSERT_EQ(trial_.Open(options.empty() ? path : path + "," + options), TANDEM_OK)
        << trial_.Error();
    ASSERT_EQ(trial_.Start(), TANDEM_OK);
    trial_.Ticks(2);
  }
  bool Moves(const Vec3& v) {
    return trial_.TicksUntil(
        [&] {
          return (Vec3(trial_.state().velocity) - v).norm() < 1e-12;
        },
        1000);
  }
  bool Turns(const Vec3& w) {
    return trial_.TicksUntil(
        [&] {
          return (Vec3(trial_.state().angular_velocity) - w).norm() < 1e-12;
        },
        1000);
  }

  const ScratchFolder folder_;
  EventFile file_;
  DriverTrial trial_;
};

TEST_F(KeyboardTest, KeysMoveTheHandWhileTheGuardKeyIsDown) {
  Begin("speed_mm_s=100");
  file_.Press({KEY_RIGHT});
  trial_.Ticks(20);
  EXPECT_TRUE(trial_.position().isZero());  // somebody types elsewhere
  file_.Press({KEY_RIGHTCTRL});
  EXPECT_TRUE(Moves(Vec3(0.1, 0, 0)));
  file_.Press({KEY_UP, KEY_PAGEUP});
  EXPECT_TRUE(Moves(Vec3(0.1, 0.1, -0.1)));
  file_.Press({KEY_RIGHT, KEY_UP, KEY_PAGEUP}, false);
  file_.Press({KEY_LEFT, KEY_DOWN, KEY_PAGEDOWN});
  EXPECT_TRUE(Moves(Vec3(-0.1, -0.1, 0.1)));
  file_.Press({KEY_RIGHTCTRL}, false);
  EXPECT_TRUE(Moves(Vec3::Zero()));
  trial_.Ticks(300);
  trial_.ExpectRealtime();
}

TEST_F(KeyboardTest, ShiftedKeysRotateTheHand) {
  Begin("guard=no,turn_deg_s=90");
  file_.Press({KEY_LEFTSHIFT, KEY_RIGHT});
  EXPECT_TRUE(Turns(Vec3(0, M_PI / 2, 0)));
  EXPECT_TRUE(Moves(Vec3::Zero()));
  file_.Press({KEY_RIGHT}, false);
  file_.Press({KEY_UP});
  EXPECT_TRUE(Turns(Vec3(-M_PI / 2, 0, 0)));
}

TEST_F(KeyboardTest, KeyRepeatIsIgnored) {
  Begin("guard=no");
  file_.Press({KEY_RIGHT});
  for (int i = 0; i < 5; ++i) file_.Send(EV_KEY, KEY_RIGHT, 2);
  EXPECT_TRUE(Moves(Vec3(0.05, 0, 0)));
  file_.Press({KEY_RIGHT}, false);
  file_.Send(EV_KEY, KEY_RIGHT, 2);
  EXPECT_TRUE(Moves(Vec3::Zero()));
}

TEST_F(KeyboardTest, LostEventsLeaveNothingPressed) {
  Begin("guard=no");
  file_.Press({KEY_RIGHT});
  EXPECT_TRUE(Moves(Vec3(0.05, 0, 0)));
  file_.Send(EV_SYN, SYN_DROPPED, 0);
  EXPECT_TRUE(Moves(Vec3::Zero()));
}

TEST_F(KeyboardTest, AnUnpluggedKeyboardStandsStill) {
  Begin("guard=no");
  file_.Press({KEY_RIGHT});
  EXPECT_TRUE(Moves(Vec3(0.05, 0, 0)));
  file_.Unplug();
  EXPECT_TRUE(trial_.TicksUntil([&] {
    return trial_.read() == TANDEM_UNPLUGGED;
  }));
  EXPECT_THAT(trial_.Error(), HasSubstr("plug it in"));
  file_.Plug();
  EXPECT_TRUE(trial_.TicksUntil([&] {
    return trial_.read() == TANDEM_OK;
  }));
  EXPECT_TRUE(Moves(Vec3::Zero()));
}

TEST_F(KeyboardTest, ReportsErrors) {
  EXPECT_EQ(trial_.Open("path=/nonexistent/event0"), TANDEM_FAILED);
  EXPECT_THAT(trial_.Error(), HasSubstr("No such file"));
  EXPECT_EQ(trial_.Open("guard=perhaps"), TANDEM_FAILED);
  EXPECT_THAT(trial_.Error(), HasSubstr("yes or no"));
}

}  // namespace
}  // namespace tandem::testing
