// Tests faults of a device while it runs, of the table in forcedimension_test.cpp.
#include <atomic>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/app/device/drivers/forcedimension/forcedimension_fixture.h"

namespace tandem::testing {
namespace {

using ::testing::HasSubstr;

TEST_F(ForceDimensionTest, ReportsWhyTheDeviceDisabledForces) {
  OpenAndStart();
  wanted_[0] = 2;
  const std::pair<int, const char*> causes[] = {
      {1, "force button"}, {2, "too fast"}, {3, "20 ms"}, {5, "USB"}, {6, "take hold"}};
  for (const auto& [cause, words] : causes) {
    fake_->vx = cause == 2 ? 1.0 : 0.0;
    trial_->Ticks(5);
    const int enabled = fake_->force_enabled;
    fake_->force_off_cause = cause;
    EXPECT_TRUE(Reads(TANDEM_FAILED)) << cause;
    EXPECT_THAT(trial_->Error(), HasSubstr(words));
    EXPECT_TRUE(trial_->TicksUntil([&] {
      return Given().isZero();
    }));
    trial_->Ticks(50);
    // a person's own switch is left alone, and so is a brake while the handle is fast
    const bool waits = cause == 1 || cause == 2 || cause == 6;
    EXPECT_EQ(fake_->force_enabled > enabled, !waits) << cause;
    if (cause == 2) {
      fake_->vx = 0;
      EXPECT_TRUE(trial_->TicksUntil([&] {
        return fake_->force_enabled > enabled;
      }));
    }
    fake_->force_off_cause = 0;
    EXPECT_TRUE(Reads(TANDEM_OK)) << cause;
  }
}

TEST_F(ForceDimensionTest, FailedCallIsATransientFailure) {
  OpenAndStart();
  fake_->error = 12;
  for (std::atomic<int>* result : {&fake_->read_result, &fake_->force_result}) {
    *result = -1;
    EXPECT_TRUE(Reads(TANDEM_FAILED));
    trial_->Ticks(50);
    EXPECT_EQ(trial_->read(), TANDEM_FAILED);
    EXPECT_THAT(trial_->Error(), HasSubstr("a call to the device failed"));
    *result = 0;
    EXPECT_TRUE(Reads(TANDEM_OK));
  }
  EXPECT_EQ(fake_->closes, 0);
}

TEST_F(ForceDimensionTest, HangingCallIsATransientFailure) {
  OpenAndStart();
  fake_->acts_as_watchdog = true;
  fake_->hang_ms = 60;
  EXPECT_TRUE(Reads(TANDEM_FAILED));
  EXPECT_THAT(trial_->Error(), HasSubstr("does not return"));
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return fake_->watchdog_trips > 0 && fake_->force_off_cause == 0;
  }));
  EXPECT_TRUE(Reads(TANDEM_OK));  // it was switched on again
  trial_->ExpectRealtime();       // read() did not wait for the call
}

TEST_F(ForceDimensionTest, AnUnpluggedDeviceIsFoundAgain) {
  OpenAndStart();
  int opens = fake_->opens;
  fake_->connected = 0;
  EXPECT_TRUE(Reads(TANDEM_UNPLUGGED));
  EXPECT_THAT(trial_->Error(), HasSubstr("plug it in"));
  fake_->connected = 1;
  fake_->y = 0.07;
  EXPECT_TRUE(Reads(TANDEM_OK));
  EXPECT_EQ(trial_->position().x(), 0.07);
  EXPECT_EQ(fake_->opens, opens + 1);
  EXPECT_EQ(fake_->closes, 1);
  // unplugged by errors alone
  fake_->status_result = -1;
  for (const int code : {2, 5, 7}) {
    opens = fake_->opens;
    fake_->error = code;
    fake_->read_result = -1;
    EXPECT_TRUE(Reads(TANDEM_UNPLUGGED)) << code;
    EXPECT_THAT(trial_->Error(), HasSubstr("does not answer"));
    fake_->read_result = 0;
    fake_->status_result = 0;
    EXPECT_TRUE(Reads(TANDEM_OK)) << code;
    EXPECT_EQ(fake_->opens, opens + 1) << code;
  }
  wanted_[1] = 1;
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return Given() == Vec3(0, 1, 0);
  }));
}

TEST_F(ForceDimensionTest, ReturningDeviceGetsNoForceBeforeItsFirstState) {
  OpenAndStart();
  wanted_[0] = 2;
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return Given().x() == 2;
  }));
  fake_->connected = 0;
  EXPECT_TRUE(Reads(TANDEM_UNPLUGGED));
  fake_->most_given = 0;
  fake_->reset = 0;  // it was switched off and on
  fake_->connected = 1;
  EXPECT_TRUE(Reads(TANDEM_UNCALIBRATED));
  trial_->Ticks(20);
  EXPECT_EQ(fake_->most_given, 0);
  fake_->reset = 1;
  EXPECT_TRUE(Reads(TANDEM_OK));
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return Given().x() == 2;
  }));
}

TEST_F(ForceDimensionTest, RetriesTheStopUntilTheForceEnds) {
  OpenAndStart();
  wanted_[0] = 2;
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return Given().x() == 2;
  }));
  fake_->failing_stops = 5;
  trial_->Close();
  EXPECT_EQ(fake_->stops, 6);
  EXPECT_TRUE(Given().isZero());
  EXPECT_FALSE(fake_->opened);
}

}  // namespace
}  // namespace tandem::testing
