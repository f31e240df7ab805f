// The driver `openhaptics` against a library with the published interface of 3D Systems' libHD.
// Faults that are injected, here or in openhaptics_faults_test.cpp (numbers: the library's error
// codes, hexadecimal):
//
// | fault | test |
// |---|---|
// | no library | DevicesCommand.ListsEachDriverWithItsRemedy, where there is none |
// | libncurses.so.5 or the vendor's driver missing | ReportsMissingLibraryFunctions |
// | no function; two libraries in one process | ReportsMissingLibraryFunctions |
// | no right to the device's file | UsbTouch.InaccessibleTouchIsReported |
// | nothing set up | ReportsMissingPartsAndRemedies |
// | the other default name; NULL, which fails on Linux | OpensTheDefaultDeviceUnderAnyName |
// | not plugged in (300), in use (301), no licence (600) | ReportsWhyOpenFails |
// | no place in the scheduler (500, 501), it fails (304) | ReportsWhyOpenFails |
// | the scheduler's rate refused (101) | KeepsTheDevicesRate |
// | a device that lacks a figure or a speed (100) | WorksWithoutOptionalFeatures |
// | a skewed transform | ReadsTheHandleAndGivesTheForceInEachFrame |
// | force errors 200 to 204 | ForceErrorEndsTheForceThenRamps |
// | 300, 302, 303, 304 while it runs; unplugged, plugged in | UnpluggedDeviceIsReopened |
// | several errors in a frame | WorstErrorCounts |
// | fatal errors 402, 500, 501 | FatalErrorIsPermanent |
// | warm motors | WarmMotorsGetLessForce |
// | not calibrated: by hand, by inkwell, by itself | ReportsMissingCalibrationWithRemedy |
// | a new calibration while it runs | RecalibrationDisablesForce |
// | stuck at (0, -110, -35) mm | ReportsMissingCalibrationWithRemedy |
// | a turn of the scheduler of 60 ms | StalledSchedulerIsAFailure |
// | a force that is no number | NeverWritesANonFiniteForce |
// | a set outside a frame (402), no force in one, a wrong thread | counted by the fake |
// | a wrong order of calls or unit of force | counted by the fake |
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <thread>

#include <dlfcn.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/app/device/drivers/openhaptics/openhaptics_fixture.h"

namespace tandem::testing {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

TEST_F(OpenHapticsTest, ReportsMissingPartsAndRemedies) {
  EXPECT_EQ(trial_->List()[0].present, 1U);
  setenv("GTDD_HOME", "/nonexistent", 1);
  auto found = trial_->List();
  EXPECT_EQ(found[0].present, 0U);
  EXPECT_THAT(found[0].mend, HasSubstr("Touch_Setup"));
  EXPECT_EQ(fake_->inits, 0);
  EXPECT_EQ(trial_->Open("speed=3"), TANDEM_FAILED);
  EXPECT_THAT(trial_->Error(), HasSubstr("'speed' is not an option of this driver"));
}

// A library stays loaded, so each try is in a process of its own.
TEST_F(OpenHapticsTest, ReportsMissingLibraryFunctions) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto said_of = [this](const char* library) {
    setenv("TANDEM_LIBHD", library, 1);
    const auto found = trial_->List();
    std::fprintf(stderr, "missing: %s, mend: %s\n", found[0].missing, found[0].mend);
    std::exit(found[0].present != 0 ? 1 : 0);
  };
  const auto exits_well = ::testing::ExitedWithCode(0);
  if (dlopen("libncurses.so.5", RTLD_LAZY) == nullptr) {
    EXPECT_EXIT(said_of(TANDEM_FAKES "/without-libncurses.so.5/libHD.so"), exits_well,
                "missing: .*libncurses.so.5.*mend: apt install libncurses5");
  }
  EXPECT_EXIT(said_of(TANDEM_FAKES "/without-libPhantomIOLib42.so/libHD.so"), exits_well,
              "mend: install 3D Systems' device driver.*libPhantomIOLib42.so belongs to it");
  EXPECT_EXIT(said_of("libm.so.6"), exits_well, "missing: .*no function hdInitDevice");
  EXPECT_EXIT(said_of("/nonexistent/libHD.so"), exits_well, "mend: install 3D Systems");
  ASSERT_EQ(trial_->Open(""), TANDEM_OK);
  // the vendor's driver of the device finds its symbols
  EXPECT_NE(dlsym(RTLD_DEFAULT, "hdInitDevice"), nullptr);
  trial_->Close();
  EXPECT_EQ(trial_->Open("library=/other/libHD.so"), TANDEM_FAILED);
  EXPECT_THAT(trial_->Error(), HasSubstr("another libHD is loaded"));
}

TEST_F(OpenHapticsTest, OpensTheDefaultDeviceUnderAnyName) {
  fake_->opens_as = 1;
  OpenAndStart();
  EXPECT_EQ(fake_->inits, 2);
  trial_->Close();
  fake_->opens_as = 2;
  OpenAndStart("device=arm");
  EXPECT_EQ(fake_->inits, 3);
}

TEST_F(OpenHapticsTest, ReportsWhyOpenFails) {
  fake_->plugged = false;
  EXPECT_EQ(trial_->Open(""), TANDEM_FAILED);
  EXPECT_THAT(trial_->Error(), HasSubstr("plug it in"));
  fake_->plugged = true;
  fake_->init_error = 0x301;
  EXPECT_EQ(trial_->Open(""), TANDEM_FAILED);
  EXPECT_THAT(trial_->Error(), HasSubstr("another program uses it"));
  fake_->init_error = 0x600;
  EXPECT_EQ(trial_->Open(""), TANDEM_FAILED);
  EXPECT_THAT(trial_->Error(), HasSubstr("licence"));
  fake_->init_error = 0;
  for (const unsigned code : {0x500U, 0x501U}) {
    fake_->schedule_error = code;
    ASSERT_EQ(trial_->Open(""), TANDEM_OK);
    EXPECT_EQ(trial_->Start(), TANDEM_FAILED);
    EXPECT_THAT(trial_->Error(), HasSubstr("scheduler has no free place"));
    trial_->Close();
  }
  fake_->schedule_error = 0;
  fake_->scheduler_fails = true;
  ASSERT_EQ(trial_->Open(""), TANDEM_OK);
  EXPECT_EQ(trial_->Start(), TANDEM_FAILED);
  EXPECT_THAT(trial_->Error(), HasSubstr("scheduler does not start"));
}

TEST_F(OpenHapticsTest, ReadsTheHandleAndGivesTheForceInEachFrame) {
  fake_->turn_y = 0.4;
  fake_->skew = 0.02;
  fake_->vx_mm = 250;
  OpenAndStart();
  EXPECT_LT((trial_->position() - Vec3(0.01, 0.02, 0.03)).norm(), 1e-12);
  EXPECT_EQ(trial_->state().velocity[0], 0.25);
  const double* q = trial_->state().orientation;
  // a whole rotation, within what the skew leaves open
  EXPECT_NEAR(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1, 1e-12);
  EXPECT_NEAR(q[1], std::sin(0.2), 1e-4);
  EXPECT_NEAR(q[3], std::cos(0.2), 1e-4);
  wanted_[0] = 1;
  wanted_[1] = -2;
  EXPECT_TRUE(Gives(Vec3(1, -2, 0)));
  EXPECT_TRUE(fake_->force_output);
  EXPECT_EQ(fake_->priority, 0xFFFF);
  const TandemDeviceCapabilities can = trial_->Capabilities();
  EXPECT_EQ(can.freedoms_in, 6U);
  EXPECT_EQ(can.freedoms_out, 3U);
  EXPECT_EQ(can.asks, 1U);
  EXPECT_EQ(can.peak_force, 3.3);
  EXPECT_EQ(can.continuous_force, 0.88);
  EXPECT_NEAR(can.stiffness, 700, 1e-9);
  EXPECT_EQ(can.workspace_max[0], 0.08);
  trial_->Ticks(400);
  trial_->ExpectRealtime();
}

TEST_F(OpenHapticsTest, SixAxisDeviceGetsTorquesInItsUnit) {
  fake_->output_dof = 6;
  OpenAndStart();
  EXPECT_EQ(trial_->Capabilities().freedoms_out, 6U);
  wanted_[5] = 0.1;
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return std::abs(fake_->torque[2] - 100) < 1e-9;
  }));
}

TEST_F(OpenHapticsTest, KeepsTheDevicesRate) {
  fake_->refuses_rate = true;
  OpenAndStart();
  EXPECT_THAT(trial_->output(), Contains(HasSubstr("its own rate")));
  EXPECT_EQ(trial_->read(), TANDEM_OK);
}

TEST_F(OpenHapticsTest, WorksWithoutOptionalFeatures) {
  // velocity, angular velocity, temperature, stiffness, forces, degrees of freedom, style
  for (const unsigned what :
       {0x2051U, 0x2053U, 0x2605U, 0x2602U, 0x2603U, 0x2604U, 0x2554U, 0x2555U}) {
    fake_->refused_get = what;
    OpenAndStart();
    trial_->Ticks(30);
    EXPECT_GE(trial_->read(), TANDEM_OK) << std::hex << what << trial_->Error();
    EXPECT_EQ(trial_->Capabilities().freedoms_out, 3U);
    EXPECT_EQ(trial_->Capabilities().peak_force, 3.3) << std::hex << what;
    const bool has_speed = what != 0x2051 && what != 0x2053;
    EXPECT_EQ((trial_->state().valid & TANDEM_HAS_VELOCITY) != 0, has_speed) << std::hex << what;
    trial_->Close();
  }
}

TEST_F(OpenHapticsTest, ResetsEncodersBeforeTheSchedulerOnRequest) {
  fake_->style = 1;
  ASSERT_EQ(trial_->Open("calibrate=yes"), TANDEM_OK);
  EXPECT_EQ(fake_->updates, 1);
  EXPECT_EQ(fake_->updated_style, 1U);
  EXPECT_FALSE(fake_->running);
}

TEST_F(OpenHapticsTest, ButtonsMapToClutchAndStop) {
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

TEST_F(OpenHapticsTest, StopAndCloseLeaveNoForce) {
  OpenAndStart();
  wanted_[0] = 2;
  ASSERT_TRUE(Gives(Vec3(2, 0, 0)));
  trial_->Stop();
  for (int i = 0; i < 500 && !Given().isZero(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_TRUE(Given().isZero());
  EXPECT_TRUE(Gives(Vec3(2, 0, 0)));
  trial_->Close();
  EXPECT_TRUE(Given().isZero());
  EXPECT_EQ(fake_->disabled, 1);
}

TEST_F(OpenHapticsTest, NeverWritesANonFiniteForce) {
  OpenAndStart();
  wanted_[0] = std::numeric_limits<double>::quiet_NaN();
  wanted_[1] = 1;
  trial_->Ticks(20);
  EXPECT_TRUE(Given().isZero());
}

}  // namespace
}  // namespace tandem::testing
