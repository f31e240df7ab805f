// The driver `forcedimension` against a library with the published interface of Force Dimension's.
// Faults that are injected, here or in forcedimension_faults_test.cpp (numbers: the library's error
// codes):
//
// | fault | test |
// |---|---|
// | no library; one without a function | ReportsMissingPartsAndRemedies |
// | no device (5) | ReportsMissingPartsAndRemedies, ReportsWhyOpenFails |
// | no right (4), busy (3), in use (20) | ReportsWhyOpenFails |
// | expert mode (9), and with it the watchdog, refused | ReportsWhyOpenFails |
// | no reference; the arm may not move itself | MissingReferenceMeansUncalibrated |
// | the arm may move itself, and does not find its reference | MovesTheArmOnlyWithPermission |
// | results 1 (time guard), 2 (saturated) | ReadsTheHandleInItsAxesAndGivesTheForce |
// | a pose that stands still | ReadsTheHandleInItsAxesAndGivesTheForce |
// | no velocity yet (fewer than two reads) | LeavesAMissingSpeedToTheHost |
// | force button, over-speed, watchdog, USB, dead man | ReportsWhyTheDeviceDisabledForces |
// | a read that fails (12), a force that does | FailedCallIsATransientFailure |
// | a call of 60 ms, by which the watchdog ends the force | HangingCallIsATransientFailure |
// | communication error (2), no device (5), timeout (7) | AnUnpluggedDeviceIsFoundAgain |
// | unplugged by the status; plugged in again | AnUnpluggedDeviceIsFoundAgain |
// | plugged in again without its reference | ReturningDeviceGetsNoForceBeforeItsFirstState |
// | dhdStop() that fails | RetriesTheStopUntilTheForceEnds |
// | a force that is no number | NeverWritesANonFiniteForce |
// | calls of a wrong device, order, thread or unit | counted by the fake in every test |
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <thread>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/app/device/drivers/forcedimension/forcedimension_fixture.h"

namespace tandem::testing {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

TEST_F(ForceDimensionTest, ReportsMissingPartsAndRemedies) {
  auto found = trial_->List();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].present, 1U);
  fake_->devices = 2;
  found = trial_->List();
  ASSERT_EQ(found.size(), 2U);
  EXPECT_STREQ(found[1].options, "device=1");
  fake_->devices = 0;
  found = trial_->List();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].present, 0U);
  EXPECT_THAT(found[0].mend, HasSubstr("udev"));
  setenv("FDSDK", "/nonexistent", 1);
  found = trial_->List();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_THAT(found[0].missing, HasSubstr("libdrd"));
  EXPECT_THAT(found[0].mend, HasSubstr("FDSDK"));
  EXPECT_EQ(fake_->opens, 0);
  EXPECT_EQ(trial_->Open("library=libm.so.6"), TANDEM_FAILED);
  EXPECT_THAT(trial_->Error(), HasSubstr("no function dhdGetDeviceCount"));
}

TEST_F(ForceDimensionTest, ReportsWhyOpenFails) {
  for (const int code : {3, 20}) {
    fake_->open_error = code;
    EXPECT_EQ(trial_->Open(""), TANDEM_FAILED);
    EXPECT_THAT(trial_->Error(), HasSubstr("another program uses it"));
  }
  fake_->open_error = 4;
  EXPECT_EQ(trial_->Open(""), TANDEM_FAILED);
  EXPECT_THAT(trial_->Error(), HasSubstr("you have no right"));
  fake_->open_error = 0;
  EXPECT_EQ(trial_->Open("device=7"), TANDEM_FAILED);
  EXPECT_THAT(trial_->Error(), HasSubstr("plug it in"));
  fake_->expert = -1;
  EXPECT_EQ(trial_->Open(""), TANDEM_FAILED);
  EXPECT_THAT(trial_->Error(), HasSubstr("watchdog"));
  EXPECT_EQ(trial_->Open("speed=3"), TANDEM_FAILED);
  EXPECT_THAT(trial_->Error(), HasSubstr("'speed' is not an option of this driver"));
}

TEST_F(ForceDimensionTest, ReadsTheHandleInItsAxesAndGivesTheForce) {
  fake_->x = 0.01;  // to the person
  fake_->y = 0.02;  // right
  fake_->z = 0.03;  // up
  fake_->vy = 0.5;
  fake_->wrist = true;
  fake_->turn_z = 0.3;
  fake_->read_result = 1;  // the time guard's: no error
  OpenAndStart();
  EXPECT_LT((trial_->position() - Vec3(0.02, 0.03, 0.01)).norm(), 1e-12);
  EXPECT_EQ(trial_->state().velocity[0], 0.5);
  // a turn about the vendor's z, upwards, is one about V's y
  const double* q = trial_->state().orientation;
  EXPECT_NEAR(q[1], std::sin(0.15), 1e-9);
  EXPECT_NEAR(q[3], std::cos(0.15), 1e-9);
  wanted_[0] = 1;
  wanted_[1] = 2;
  wanted_[2] = 3;
  wanted_[3] = 0.1;  // this wrist has no motors
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return Given() == Vec3(1, 2, 3);
  }));
  EXPECT_EQ(fake_->force[4], 0);
  // it stands still, and goes on when it does not
  trial_->Ticks(30);
  fake_->y = 0.05;
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return trial_->position().x() == 0.05;
  }));
  trial_->Ticks(500);
  trial_->ExpectRealtime();
}

TEST_F(ForceDimensionTest, ReportsCapabilitiesAndSetsTheDevicesGuards) {
  fake_->type = 104;
  fake_->wrist = true;
  fake_->active_wrist = true;
  OpenAndStart();
  const TandemDeviceCapabilities can = trial_->Capabilities();
  EXPECT_EQ(can.freedoms_in, 6U);
  EXPECT_EQ(can.freedoms_out, 6U);
  EXPECT_EQ(can.asks, 1U);
  EXPECT_EQ(can.peak_force, 12);
  EXPECT_EQ(can.peak_moment, 0.2);
  EXPECT_EQ(fake_->watchdog, 160);  // 20 ms
  EXPECT_EQ(fake_->most_force, 12);
  EXPECT_EQ(fake_->most_torque, 0.2);
  EXPECT_EQ(fake_->gravity, 1);
  wanted_[4] = 0.1;  // about V's y, the vendor's z
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return fake_->force[5] == 0.1;
  }));
}

TEST_F(ForceDimensionTest, KnowsEachModelsCapabilities) {
  const std::pair<int, double> models[] = {{34, 12}, {36, 12}, {60, 8}, {63, 20}, {109, 12}};
  for (const auto& [type, force_N] : models) {
    fake_->type = type;
    ASSERT_EQ(trial_->Open(""), TANDEM_OK);
    EXPECT_EQ(trial_->Capabilities().peak_force, force_N) << type;
    EXPECT_EQ(fake_->most_force, force_N) << type;
    EXPECT_EQ(trial_->Capabilities().freedoms_in, 3U);
    EXPECT_EQ(trial_->Capabilities().moves_by_itself, 0U);
    trial_->Close();
  }
}

TEST_F(ForceDimensionTest, LeavesAMissingSpeedToTheHost) {
  fake_->velocity_result = -1;
  OpenAndStart();
  EXPECT_EQ(trial_->state().valid, std::uint32_t{TANDEM_HAS_POSE});
  fake_->velocity_result = 0;
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return (trial_->state().valid & TANDEM_HAS_VELOCITY) != 0;
  }));
}

TEST_F(ForceDimensionTest, ButtonsMapToClutchAndStop) {
  OpenAndStart("clutch=1,stop=0");
  fake_->buttons = 2;
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return trial_->state().buttons == TANDEM_BUTTON_CLUTCH;
  }));
  fake_->buttons = 1;
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return trial_->state().buttons == TANDEM_BUTTON_STOP;
  }));
}

TEST_F(ForceDimensionTest, MissingReferenceMeansUncalibrated) {
  OpenAndStart();
  EXPECT_EQ(fake_->auto_inits, 0);
  fake_->reset = 0;
  EXPECT_TRUE(Reads(TANDEM_UNCALIBRATED));
  EXPECT_THAT(trial_->Error(), HasSubstr("calibrate=yes"));
  fake_->reset = 1;
  EXPECT_TRUE(Reads(TANDEM_OK));
}

TEST_F(ForceDimensionTest, MovesTheArmOnlyWithPermission) {
  fake_->initialised = false;
  fake_->auto_init = -1;
  ASSERT_EQ(trial_->Open("calibrate=yes"), TANDEM_OK);
  EXPECT_EQ(fake_->auto_inits, 0);  // only start() moves it
  EXPECT_EQ(trial_->Start(), TANDEM_FAILED);
  EXPECT_THAT(trial_->Error(), HasSubstr("did not find its reference"));
  EXPECT_THAT(trial_->output(), Contains(HasSubstr("the arm moves by itself now")));
  trial_->Close();
  fake_->auto_init = 0;
  OpenAndStart("calibrate=yes");
  wanted_[0] = 1;
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return Given() == Vec3(1, 0, 0);
  }));
  EXPECT_EQ(trial_->Capabilities().moves_by_itself, 1U);
  EXPECT_EQ(fake_->auto_inits, 2);
}

TEST_F(ForceDimensionTest, StopIsZeroUntilTheNextWrite) {
  OpenAndStart();
  wanted_[0] = 2;
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return Given().x() == 2;
  }));
  trial_->Stop();
  for (int i = 0; i < 500 && !Given().isZero(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_TRUE(Given().isZero());
  trial_->Ticks(1);
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return Given().x() == 2;
  }));
}

TEST_F(ForceDimensionTest, NeverWritesANonFiniteForce) {
  OpenAndStart();
  wanted_[0] = std::numeric_limits<double>::quiet_NaN();
  wanted_[1] = 1;
  const long forces = fake_->forces;
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return fake_->forces > forces + 3;
  }));
  EXPECT_TRUE(Given().isZero());
}

}  // namespace
}  // namespace tandem::testing
