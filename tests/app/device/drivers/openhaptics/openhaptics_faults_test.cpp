// Tests faults of a device while it runs, of the table in openhaptics_test.cpp.
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/app/device/drivers/openhaptics/openhaptics_fixture.h"

namespace tandem::testing {
namespace {

using ::testing::HasSubstr;

TEST_F(OpenHapticsTest, ForceErrorEndsTheForceThenRamps) {
  OpenAndStart();
  wanted_[0] = 2;
  const std::pair<unsigned, const char*> errors[] = {{0x200, "too warm"},
                                                     {0x201, "more force"},
                                                     {0x202, "too fast"},
                                                     {0x203, "handle"},
                                                     {0x204, "force error"}};
  for (const auto& [code, words] : errors) {
    ASSERT_TRUE(Gives(Vec3(2, 0, 0))) << code;
    fake_->frame_error = code;
    EXPECT_TRUE(Reads(TANDEM_FAILED)) << code;
    EXPECT_THAT(trial_->Error(), HasSubstr(words));
    EXPECT_TRUE(Gives(Vec3::Zero())) << code;
    // from nothing to all in 200 frames
    ASSERT_TRUE(trial_->TicksUntil([&] {
      return Given().x() > 0;
    }));
    EXPECT_LT(Given().x(), 1);
    const long begun = fake_->frames;
    ASSERT_TRUE(Gives(Vec3(2, 0, 0))) << code;
    EXPECT_GT(fake_->frames - begun, 100);
    EXPECT_TRUE(Reads(TANDEM_OK)) << code;
  }
}

TEST_F(OpenHapticsTest, WorstErrorCounts) {
  OpenAndStart();
  fake_->frame_error = 0x302;
  fake_->later_error = 0x104;  // the handle is bad because the device is gone
  EXPECT_TRUE(Reads(TANDEM_UNPLUGGED));
  EXPECT_TRUE(Reads(TANDEM_OK));
  fake_->frame_error = 0x501;
  fake_->later_error = 0x201;
  EXPECT_TRUE(Reads(TANDEM_BROKEN));
}

TEST_F(OpenHapticsTest, UnpluggedDeviceIsReopened) {
  OpenAndStart();
  const int inits = fake_->inits;
  fake_->plugged = false;
  EXPECT_TRUE(Reads(TANDEM_UNPLUGGED));
  EXPECT_THAT(trial_->Error(), HasSubstr("plug it in"));
  trial_->Ticks(100);
  fake_->plugged = true;
  fake_->x_mm = 55;
  EXPECT_TRUE(Reads(TANDEM_OK));
  EXPECT_EQ(trial_->position().x(), 0.055);
  EXPECT_GT(fake_->inits, inits);
  wanted_[1] = 1;
  EXPECT_TRUE(Gives(Vec3(0, 1, 0)));
  for (const unsigned code : {0x300U, 0x303U, 0x304U}) {
    trial_->Ticks(50);
    fake_->frame_error = code;
    EXPECT_TRUE(Reads(TANDEM_UNPLUGGED)) << code;
    EXPECT_TRUE(Reads(TANDEM_OK)) << code;
  }
}

TEST_F(OpenHapticsTest, FatalErrorIsPermanent) {
  wanted_[0] = 2;
  for (const unsigned code : {0x402U, 0x500U, 0x501U}) {
    OpenAndStart();
    ASSERT_TRUE(Gives(Vec3(2, 0, 0)));
    fake_->frame_error = code;
    EXPECT_TRUE(Reads(TANDEM_BROKEN)) << code;
    EXPECT_THAT(trial_->Error(), HasSubstr("start it again"));
    EXPECT_TRUE(Gives(Vec3::Zero()));
    trial_->Ticks(50);
    EXPECT_EQ(trial_->read(), TANDEM_BROKEN);
    trial_->Close();
  }
}

TEST_F(OpenHapticsTest, WarmMotorsGetLessForce) {
  OpenAndStart();
  wanted_[0] = 2;
  ASSERT_TRUE(Gives(Vec3(2, 0, 0)));
  fake_->temperature = 0.8;
  // 0.999 a tick: 0.7 after 357
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return Given().x() < 1.4;
  }));
  fake_->temperature = 0.4;
  EXPECT_TRUE(Gives(Vec3(2, 0, 0)));
}

TEST_F(OpenHapticsTest, ReportsMissingCalibrationWithRemedy) {
  fake_->calibration = 0x5002;  // a person has to
  OpenAndStart();
  EXPECT_TRUE(Reads(TANDEM_UNCALIBRATED));
  EXPECT_THAT(trial_->Error(), HasSubstr("inkwell"));
  fake_->calibration = 0x5001;  // the library can by itself
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return fake_->updates > 0;
  }));
  EXPECT_EQ(fake_->updated_style, 4U);
  fake_->calibration = 0x5000;
  EXPECT_TRUE(Reads(TANDEM_OK));
  wanted_[0] = 1;
  EXPECT_TRUE(Gives(Vec3(1, 0, 0)));
  fake_->style = 1;
  // an uncalibrated Touch is stuck there
  fake_->x_mm = 0;
  fake_->y_mm = -110;
  fake_->z_mm = -35;
  EXPECT_TRUE(Reads(TANDEM_UNCALIBRATED));
  EXPECT_THAT(trial_->Error(), HasSubstr("take it out"));
  EXPECT_TRUE(Gives(Vec3::Zero()));
  fake_->x_mm = 3;
  EXPECT_TRUE(Reads(TANDEM_OK));
  // arms without an inkwell
  trial_->Close();
  fake_->calibration = 0x5002;
  OpenAndStart();
  EXPECT_TRUE(Reads(TANDEM_UNCALIBRATED));
  EXPECT_THAT(trial_->Error(), HasSubstr("calibrate=yes"));
}

TEST_F(OpenHapticsTest, RecalibrationDisablesForce) {
  fake_->style = 2;
  OpenAndStart();
  wanted_[0] = 2;
  ASSERT_TRUE(Gives(Vec3(2, 0, 0)));
  fake_->calibration = 0x5001;
  EXPECT_TRUE(Reads(TANDEM_UNCALIBRATED));  // the pose jumps: the host takes it up anew
  EXPECT_THAT(trial_->Error(), HasSubstr("calibrates itself"));
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return fake_->updates > 0;
  }));
  EXPECT_EQ(fake_->updated_style, 2U);
  fake_->calibration = 0x5000;
  EXPECT_TRUE(Reads(TANDEM_OK));
  EXPECT_TRUE(Gives(Vec3(2, 0, 0)));
}

TEST_F(OpenHapticsTest, StalledSchedulerIsAFailure) {
  OpenAndStart();
  fake_->hang_ms = 60;
  EXPECT_TRUE(Reads(TANDEM_FAILED));
  EXPECT_THAT(trial_->Error(), HasSubstr("scheduler has stopped"));
  EXPECT_TRUE(Reads(TANDEM_OK));
  trial_->ExpectRealtime();
}

}  // namespace
}  // namespace tandem::testing
