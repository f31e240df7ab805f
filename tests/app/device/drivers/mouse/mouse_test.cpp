// The driver `mouse` against a pipe of input events. Faults that are injected: no right and no
// device (ReportsErrors), events that were lost (LostEventsLeaveNothingPressed), unplugged while
// it moves and plugged in again (AnUnpluggedMouseStandsStill), events of other kinds
// (MovesWhileTheButtonIsHeld).
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/app/device/driver_trial.h"
#include "tests/app/device/drivers/event_file.h"
#include "tests/support/scratch_folder.h"

namespace tandem::testing {
namespace {

using ::testing::HasSubstr;

class MouseTest : public ::testing::Test {
 protected:
  MouseTest() : file_(folder_.path() / "event7"), trial_("mouse") {}
  void Begin(const std::string& options = "") {
    const std::string path = "path=" + (folder_.path() / "event7").string();
    ASSERT_EQ(trial_.Open(options.empty() ? path : path + "," + options), TANDEM_OK)
        << trial_.Error();
    ASSERT_EQ(trial_.Start(), TANDEM_OK);
    trial_.Ticks(2);
  }
  bool ComesTo(const Vec3& p) {
    return trial_.TicksUntil(
        [&] {
          return (trial_.position() - p).norm() < 2e-5;
        },
        1000);
  }

  const ScratchFolder folder_;
  EventFile file_;
  DriverTrial trial_;
};

TEST_F(MouseTest, MovesWhileTheButtonIsHeld) {
  Begin("mm_per_count=0.1");
  file_.Send(EV_REL, REL_X, 100);
  trial_.Ticks(50);
  EXPECT_TRUE(trial_.position().isZero());
  file_.Press({BTN_MIDDLE});
  file_.Send(EV_REL, REL_X, 100);
  file_.Send(EV_REL, REL_Y, 50);
  file_.Send(EV_REL, REL_HWHEEL, 9);
  file_.Send(EV_ABS, 0, 700);
  EXPECT_TRUE(ComesTo(Vec3(0.01, -0.005, 0)));
  file_.Send(EV_REL, REL_WHEEL, 1);
  EXPECT_TRUE(ComesTo(Vec3(0.01, -0.005, -0.004)));
  file_.Press({BTN_MIDDLE}, false);
  file_.Send(EV_REL, REL_X, 100);
  trial_.Ticks(50);
  EXPECT_NEAR(trial_.position().x(), 0.01, 2e-5);
  trial_.Ticks(300);
  trial_.ExpectRealtime();
}

TEST_F(MouseTest, RotatesWithTheLeftButtonHeld) {
  Begin("hold=none,deg_per_count=0.5");
  file_.Press({BTN_LEFT});
  file_.Send(EV_REL, REL_X, 20);  // 10 degrees about the axis upwards
  EXPECT_TRUE(trial_.TicksUntil([&] {
    return std::abs(trial_.state().orientation[1] - std::sin(5 * M_PI / 180)) < 1e-4;
  }));
  EXPECT_TRUE(trial_.position().isZero());
}

TEST_F(MouseTest, LostEventsLeaveNothingPressed) {
  Begin();
  file_.Press({BTN_MIDDLE});
  trial_.Ticks(5);
  file_.Send(EV_SYN, SYN_DROPPED, 0);
  file_.Send(EV_REL, REL_X, 100);
  trial_.Ticks(50);
  EXPECT_TRUE(trial_.position().isZero());
}

TEST_F(MouseTest, AnUnpluggedMouseStandsStill) {
  Begin();
  file_.Press({BTN_MIDDLE});
  file_.Send(EV_REL, REL_X, 10'000);
  trial_.Ticks(3);
  file_.Unplug();
  EXPECT_TRUE(trial_.TicksUntil([&] {
    return trial_.read() == TANDEM_UNPLUGGED;
  }));
  EXPECT_THAT(trial_.Error(), HasSubstr("plug it in"));
  file_.Plug();
  EXPECT_TRUE(trial_.TicksUntil([&] {
    return trial_.read() == TANDEM_OK;
  }));
  const Vec3 at = trial_.position();
  file_.Send(EV_REL, REL_X, 100);  // the button is not held any more
  trial_.Ticks(30);
  EXPECT_EQ(trial_.position(), at);
  EXPECT_EQ(trial_.Error(), "");
}

TEST_F(MouseTest, ReportsErrors) {
  EXPECT_EQ(trial_.Open("path=/nonexistent/event0"), TANDEM_FAILED);
  EXPECT_THAT(trial_.Error(), HasSubstr("No such file"));
  EXPECT_EQ(trial_.Open("hold=left"), TANDEM_FAILED);
  EXPECT_THAT(trial_.Error(), HasSubstr("middle, right, side or none"));
  const auto found = trial_.List();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].present != 0, found[0].missing[0] == '\0');
  EXPECT_EQ(found[0].missing[0] == '\0', found[0].mend[0] == '\0');
}

}  // namespace
}  // namespace tandem::testing
