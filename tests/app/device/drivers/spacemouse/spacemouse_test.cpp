// The driver `spacemouse` against a daemon with spacenavd's protocol. Faults that are injected:
//
// | fault | test |
// |---|---|
// | no daemon, no device | ReportsMissingPartsAndRemedies |
// | a daemon of protocol version 0 | SpeaksBothVersionsOfTheProtocol |
// | a daemon that does not answer the handshake | SpeaksBothVersionsOfTheProtocol |
// | an event before an answer | SpeaksBothVersionsOfTheProtocol |
// | a puck held still tells nothing more | ConstantDeflectionKeepsMoving |
// | an event in two parts; unknown events; an all-zero packet | ReadsFragmentedEvents |
// | unplugged without a last zero; plugged in again | UnpluggedPuckStopsAndResumes |
// | the daemon dies as the puck is pushed, and is back | DeadDaemonStopsTheHandUntilItReturns |
// | buttons beyond all numbers | ButtonsMapToClutchAndStop |
#include <cmath>
#include <cstdlib>
#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/app/device/driver_trial.h"
#include "tests/app/device/drivers/spacemouse/fake_daemon.h"
#include "tests/support/scratch_folder.h"

namespace tandem::testing {
namespace {

using ::testing::HasSubstr;

class SpaceMouseTest : public ::testing::Test {
 protected:
  SpaceMouseTest() : socket_(folder_.path() / "spnav.sock"), trial_("spacemouse") {
    setenv("SPNAV_SOCKET", socket_.c_str(), 1);
  }
  void Begin(const std::string& options = "", int version = 1) {
    daemon_.reset();
    daemon_ = std::make_unique<FakeDaemon>(socket_, version);
    ASSERT_EQ(trial_.Open(options), TANDEM_OK) << trial_.Error();
    ASSERT_EQ(trial_.Start(), TANDEM_OK);
    trial_.Ticks(3);
  }
  Vec3 velocity() const { return Vec3(trial_.state().velocity); }
  bool Moves(const Vec3& v) {
    return trial_.TicksUntil(
        [&] {
          return (velocity() - v).norm() < 1e-9;
        },
        1000);
  }
  bool Reads(std::int32_t result) {
    return trial_.TicksUntil([&] {
      return trial_.read() == result;
    });
  }

  const ScratchFolder folder_;
  const std::filesystem::path socket_;
  std::unique_ptr<FakeDaemon> daemon_;
  DriverTrial trial_;
};

TEST_F(SpaceMouseTest, ReportsMissingPartsAndRemedies) {
  auto found = trial_.List();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].present, 0U);
  EXPECT_THAT(found[0].missing, HasSubstr("spacenavd does not answer"));
  EXPECT_THAT(found[0].mend, HasSubstr("apt install spacenavd"));
  EXPECT_EQ(trial_.Open(""), TANDEM_FAILED);
  EXPECT_THAT(trial_.Error(), HasSubstr("apt install spacenavd"));
  daemon_ = std::make_unique<FakeDaemon>(socket_, 1);
  daemon_->axes = 0;
  found = trial_.List();
  EXPECT_EQ(found[0].present, 0U);
  EXPECT_THAT(found[0].mend, HasSubstr("plug it in"));
  daemon_->axes = 6;
  EXPECT_EQ(trial_.List()[0].present, 1U);
  EXPECT_EQ(trial_.Open("mode=sideways"), TANDEM_FAILED);
  EXPECT_THAT(trial_.Error(), HasSubstr("object or camera"));
  EXPECT_EQ(trial_.Open("speed=3"), TANDEM_FAILED);
  EXPECT_THAT(trial_.Error(), HasSubstr("'speed' is not an option of this driver"));
}

TEST_F(SpaceMouseTest, SpeaksBothVersionsOfTheProtocol) {
  for (const int version : {0, 1}) {
    Begin("dead_zone=0", version);
    EXPECT_TRUE(trial_.TicksUntil([&] {
      return daemon_->sensitivity == (version == 0 ? 1.0F : 0.0F);
    }));
    daemon_->Motion(350, 0, 0);
    EXPECT_TRUE(Moves(Vec3(0.1, 0, 0))) << version;
    trial_.Close();
  }
  // an event comes before the answer to the request for devices
  daemon_->event_first = true;
  ASSERT_EQ(trial_.Open("dead_zone=0"), TANDEM_OK) << trial_.Error();
  ASSERT_EQ(trial_.Start(), TANDEM_OK);
  EXPECT_TRUE(Moves(Vec3(0, 0.1, 0)));
}

TEST_F(SpaceMouseTest, EventBeforeTheHandshakesAnswerIsNotMisread) {
  daemon_ = std::make_unique<FakeDaemon>(socket_, 1);
  daemon_->event_before_hello = true;
  ASSERT_EQ(trial_.Open("dead_zone=0"), TANDEM_OK) << trial_.Error();
  ASSERT_EQ(trial_.Start(), TANDEM_OK);
  EXPECT_TRUE(Moves(Vec3(0, 0.1, 0)));
  daemon_->Motion(350, 0, 0);
  EXPECT_TRUE(Moves(Vec3(0.1, 0, 0)));
  daemon_->Motion(0, 0, 0);  // the hand lets the puck go
  EXPECT_TRUE(Moves(Vec3::Zero()));
}

TEST_F(SpaceMouseTest, LateHandshakeAnswerRestartsIt) {
  daemon_ = std::make_unique<FakeDaemon>(socket_, 1);
  daemon_->hello_ms = 400;
  ASSERT_EQ(trial_.Open("dead_zone=0"), TANDEM_OK) << trial_.Error();
  ASSERT_EQ(trial_.Start(), TANDEM_OK);
  EXPECT_TRUE(trial_.TicksUntil([&] {
    return daemon_->clients == 2;
  }));
  EXPECT_TRUE(Reads(TANDEM_OK));
  daemon_->Motion(350, 0, 0);
  EXPECT_TRUE(Moves(Vec3(0.1, 0, 0)));
}

TEST_F(SpaceMouseTest, HungDaemonStopsTheHand) {
  Begin("dead_zone=0");
  daemon_->Motion(350, 0, 0);
  ASSERT_TRUE(Moves(Vec3(0.1, 0, 0)));
  daemon_->answers = false;
  EXPECT_TRUE(Reads(TANDEM_UNPLUGGED));
  daemon_->answers = true;
  EXPECT_TRUE(Reads(TANDEM_OK));
  EXPECT_TRUE(velocity().isZero());
}

TEST_F(SpaceMouseTest, OneOfTwoDevicesRemovedLeavesTheOther) {
  Begin("dead_zone=0");
  daemon_->Motion(350, 0, 0);
  ASSERT_TRUE(Moves(Vec3(0.1, 0, 0)));
  daemon_->Send({3, 1, 4});  // removed; the daemon still has six axes
  EXPECT_TRUE(Moves(Vec3::Zero()));
  EXPECT_TRUE(Reads(TANDEM_OK));
}

TEST_F(SpaceMouseTest, MovesTheHandAtTheConfiguredSpeeds) {
  Begin("dead_zone=0,speed_mm_s=200,turn_deg_s=90");
  daemon_->Motion(175, 350, 350);  // right, up, away
  EXPECT_TRUE(Moves(Vec3(0.1, 0.2, -0.2)));
  const Vec3 from = trial_.position();
  trial_.Ticks(100);
  EXPECT_GT((trial_.position() - from).norm(), 0.02);
  daemon_->Motion(0, 0, 0, 350, 0, 350);
  EXPECT_TRUE(Moves(Vec3::Zero()));
  EXPECT_TRUE(trial_.TicksUntil([&] {
    return std::abs(trial_.state().angular_velocity[0] - M_PI / 2) < 1e-9 &&
           std::abs(trial_.state().angular_velocity[2] + M_PI / 2) < 1e-9;
  }));
  trial_.Ticks(400);
  trial_.ExpectRealtime();
}

TEST_F(SpaceMouseTest, ViewModeInvertsTheMotion) {
  Begin("dead_zone=0,mode=camera");
  daemon_->Motion(350, 0, 0);
  EXPECT_TRUE(Moves(Vec3(-0.1, 0, 0)));
}

TEST_F(SpaceMouseTest, DominantAxisModeMovesOneAxis) {
  Begin("dead_zone=0,dominant=yes");
  daemon_->Motion(200, 300, -250, 100, 0, 0);
  EXPECT_TRUE(Moves(Vec3(0, 0.1 * 300 / 350, 0)));
  EXPECT_EQ(trial_.state().angular_velocity[0], 0);
}

TEST_F(SpaceMouseTest, DeadZoneIsLeftWithoutAJump) {
  Begin("dead_zone=0.2");
  daemon_->Motion(69, 0, 0);
  trial_.Ticks(30);
  EXPECT_EQ(velocity().x(), 0);
  daemon_->Motion(350, 0, 0);
  EXPECT_TRUE(Moves(Vec3(0.1, 0, 0)));
}

TEST_F(SpaceMouseTest, ConstantDeflectionKeepsMoving) {
  Begin("dead_zone=0");
  daemon_->Motion(350, 0, 0);
  ASSERT_TRUE(Moves(Vec3(0.1, 0, 0)));
  const double from = trial_.position().x();
  trial_.Ticks(500);  // the kernel drops values that are equal: nothing comes
  EXPECT_NEAR(trial_.position().x() - from, 0.05, 0.02);
}

TEST_F(SpaceMouseTest, ReadsFragmentedEvents) {
  Begin("dead_zone=0");
  for (const std::size_t first : {1U, 4U, 31U}) {
    daemon_->Send({0, 350, 0, 0, 0, 0, 0, 8}, first);
    EXPECT_TRUE(Moves(Vec3(0.1, 0, 0))) << first;
    daemon_->Send({});  // a masked event may come like this: no motion
    EXPECT_TRUE(Moves(Vec3::Zero()));
  }
  for (const std::int32_t kind : {4, 5, 6, 99, -1, 0x7faa2002}) daemon_->Send({kind, 350, 350});
  daemon_->Motion(0, 350, 0);
  EXPECT_TRUE(Moves(Vec3(0, 0.1, 0)));
}

TEST_F(SpaceMouseTest, UnpluggedPuckStopsAndResumes) {
  Begin("dead_zone=0");
  daemon_->Motion(350, 0, 0);
  ASSERT_TRUE(Moves(Vec3(0.1, 0, 0)));
  daemon_->axes = 0;
  daemon_->Send({3, 1, 0});  // removed, without a last zero motion
  EXPECT_TRUE(Reads(TANDEM_UNPLUGGED));
  EXPECT_THAT(trial_.Error(), HasSubstr("plug it in"));
  const Vec3 at = trial_.position();
  trial_.Ticks(50);
  daemon_->axes = 6;
  daemon_->Send({3, 0, 0});  // added
  EXPECT_TRUE(Reads(TANDEM_OK));
  EXPECT_LT((trial_.position() - at).norm(), 1e-6);
  EXPECT_TRUE(velocity().isZero());
  EXPECT_EQ(trial_.Error(), "");
}

TEST_F(SpaceMouseTest, DeadDaemonStopsTheHandUntilItReturns) {
  Begin("dead_zone=0");
  daemon_->Motion(350, 0, 0);
  ASSERT_TRUE(Moves(Vec3(0.1, 0, 0)));
  daemon_->Die();
  EXPECT_TRUE(Reads(TANDEM_UNPLUGGED));
  EXPECT_THAT(trial_.Error(), HasSubstr("systemctl start spacenavd"));
  daemon_->Rise();
  EXPECT_TRUE(Reads(TANDEM_OK));
  EXPECT_TRUE(velocity().isZero());
  daemon_->Motion(0, 350, 0);
  EXPECT_TRUE(Moves(Vec3(0, 0.1, 0)));
}

TEST_F(SpaceMouseTest, ButtonsMapToClutchAndStop) {
  Begin("clutch=1,stop=0");
  daemon_->Send({1, 1});
  EXPECT_TRUE(trial_.TicksUntil([&] {
    return trial_.state().buttons == TANDEM_BUTTON_CLUTCH;
  }));
  daemon_->Send({2, 1});
  daemon_->Send({1, 0});
  EXPECT_TRUE(trial_.TicksUntil([&] {
    return trial_.state().buttons == TANDEM_BUTTON_STOP;
  }));
  daemon_->Send({1, 1'000'000});
  daemon_->Send({1, -5});
  daemon_->Send({2, 0});
  EXPECT_TRUE(trial_.TicksUntil([&] {
    return trial_.state().buttons == 0;
  }));
}

TEST_F(SpaceMouseTest, ForceHoldsTheHandBack) {
  Begin("dead_zone=0");
  daemon_->Motion(350, 350, 0);
  ASSERT_TRUE(Moves(Vec3(0.1, 0.1, 0)));
  trial_.Ticks(200, Vec3(-2.5, 0, 0));
  EXPECT_LT(velocity().x(), 0);
  EXPECT_NEAR(velocity().y(), 0.1, 1e-9);
  trial_.Ticks(100);
  EXPECT_NEAR(velocity().x(), 0.1, 1e-9);
}

TEST_F(SpaceMouseTest, ClearlyStrongerAxisTakesOver) {
  Begin("dead_zone=0,dominant=yes");
  daemon_->Motion(300, 200, 0);
  EXPECT_TRUE(Moves(Vec3(0.1 * 300 / 350, 0, 0)));
  daemon_->Motion(300, 320, 0);
  EXPECT_TRUE(Moves(Vec3(0.1 * 300 / 350, 0, 0)));
  trial_.Ticks(20);
  EXPECT_EQ(velocity().y(), 0);
  daemon_->Motion(200, 300, 0);
  EXPECT_TRUE(Moves(Vec3(0, 0.1 * 300 / 350, 0)));
}

}  // namespace
}  // namespace tandem::testing
